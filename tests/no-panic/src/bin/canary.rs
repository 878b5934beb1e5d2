//! Panics for some inputs: must not link.
#![no_std]
#![no_main]

use core::hint::black_box;

tetrad_no_panic::program!({
    let table = black_box([1_u8, 2, 3]);
    black_box(table[black_box(2_usize)])
});
