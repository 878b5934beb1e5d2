//! Any bytes as a session's file: refused with a reason, cut short, or read; never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tetrad::session::schema::foxglove::RawImage;
use tetrad::session::schema::tetrad::{Hand, Instant, Observations};
use tetrad::session::{Beginning, Lookup, Reader, Topic};

fuzz_target!(|data: &[u8]| {
    let Ok(mut reader) =
        Reader::of(std::io::Cursor::new(data.to_vec()), data.len() as u64, "fuzz.mcap".as_ref())
    else {
        return;
    };
    let message = reader.beginning().message();
    assert!(Beginning::of(&message).is_ok(), "what was understood is understood again");
    if let Ok(mut lookup) = Lookup::of(&reader, std::io::Cursor::new(data), data.len() as u64) {
        let spots: Vec<_> = lookup.index().topics().flat_map(|(_, spots)| spots.to_vec()).take(64).collect();
        for spot in spots {
            let _ = lookup.moment(spot.time_us);
            let _ = lookup.picture(0, spot.time_us, |view| view.pixel(0, 0));
        }
    }
    while let Ok(Some(entry)) = reader.next_entry() {
        match entry.topic {
            Topic::Image(_) => drop(reader.decode::<RawImage>(&entry)),
            Topic::Observations(_) => drop(reader.decode::<Observations>(&entry)),
            Topic::Hand => drop(reader.decode::<Hand>(&entry)),
            Topic::Instant => drop(reader.decode::<Instant>(&entry)),
            _ => {}
        }
    }
});
