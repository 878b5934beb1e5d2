//! Promise: six CiA 402 drives are brought to operation without a jump, follow every set-point, and are
//! brought to rest, with the reason, whatever fails.

mod bench;

mod bringing_up;

mod failing;

#[cfg(target_os = "linux")]
mod hub;

#[cfg(target_os = "linux")]
mod peers;

mod port;

mod threadless;
