//! The log: defmt's frames in memory, where a debug probe reads them (RTT) while the board runs. Nothing waits for the
//! probe: what it has not read when the buffer is full is lost.

use defmt_rtt as _;
use embassy_time::Instant;

defmt::timestamp!("{=u64:us}", Instant::now().as_micros());
