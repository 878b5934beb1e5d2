//! Buffers for pictures, where DMA reaches them.
//!
//! They lie in the SRAM on the AXI bus, alone: once they are made, DMA alone writes to them and the
//! processor only reads. So the data cache holds nothing of them that is not in memory, and what it holds
//! may be forgotten at any time: that is done for a buffer when a picture has come into it, so that it is
//! read anew.

use crate::handover::{BUFFERS, PictureBuffer};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::SCB;

/// A line of the processor's data cache, bytes: buffers begin and end with one.
const CACHE_LINE: usize = 32;

const _: () = assert!(align_of::<PictureBuffer>().is_multiple_of(CACHE_LINE));
const _: () = assert!(size_of::<PictureBuffer>().is_multiple_of(CACHE_LINE));

struct Place(UnsafeCell<MaybeUninit<[PictureBuffer; BUFFERS]>>);

// SAFETY: `take` gives it away once, and nothing else looks at it.
unsafe impl Sync for Place {}

// no value for it is kept in flash: `take` makes it
#[unsafe(link_section = ".pictures")]
static PLACE: Place = Place(UnsafeCell::new(MaybeUninit::uninit()));

static TAKEN: AtomicBool = AtomicBool::new(false);

/// The buffers, all black; `None` the second time. To be called before the data cache is switched on: what
/// is written here would wait in it.
pub fn take() -> Option<&'static mut [PictureBuffer; BUFFERS]> {
    if TAKEN.swap(true, Ordering::SeqCst) || SCB::dcache_enabled() {
        return None;
    }
    let place = PLACE.0.get().cast::<[PictureBuffer; BUFFERS]>();
    // SAFETY: the only reference there is, for this line is reached once; bytes of 0 are such buffers.
    // Words of this memory are corrected by a code that is made when they are written, so that they have to
    // be.
    unsafe {
        place.write_bytes(0, 1);
        Some(&mut *place)
    }
}

/// The buffer as words, which is what DMA writes.
pub(super) fn words(buffer: &mut PictureBuffer) -> &mut [u32] {
    // SAFETY: any four bytes are a word.
    let (_, words, _) = unsafe { buffer.0.align_to_mut() };
    words
}

/// Has the processor read the buffer anew, into which DMA has written.
pub(super) fn read_anew(scb: &mut SCB, buffer: &mut PictureBuffer) {
    let (start, length) = (buffer.0.as_ptr() as usize, size_of::<PictureBuffer>());
    // SAFETY: it begins and ends with a line of the cache, see above; nothing of it waits there to be
    // written, for the processor only reads it, and memory holds the picture.
    unsafe { scb.invalidate_dcache_by_address(start, length) }
}
