//! Clocks: the crystal of 12 MHz, the processor at 400 MHz.
//!
//! Silicon of revision V can do 480 MHz, that of revision Y, which the first of these boards have, cannot.

use embassy_stm32::Config;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk,
    VoltageScale, mux,
};
use embassy_stm32::time::Hertz;

/// The settings of the whole chip.
pub(super) fn settings() -> Config {
    let mut settings = Config::default();
    let rcc = &mut settings.rcc;
    rcc.hse = Some(Hse { freq: Hertz(12_000_000), mode: HseMode::Oscillator });
    rcc.pll1 = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV3,
        mul: PllMul::MUL200,
        fracn: None,
        divp: Some(PllDiv::DIV2),
        // 80 MHz for CAN, which has a whole number of them in a bit of each rate
        divq: Some(PllDiv::DIV10),
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    rcc.apb1_pre = APBPrescaler::DIV2;
    rcc.apb2_pre = APBPrescaler::DIV2;
    rcc.apb3_pre = APBPrescaler::DIV2;
    rcc.apb4_pre = APBPrescaler::DIV2;
    rcc.voltage_scale = VoltageScale::Scale1;
    rcc.mux.fdcansel = mux::Fdcansel::PLL1_Q;
    settings
}
