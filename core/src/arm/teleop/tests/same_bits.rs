//! The same commands give the same goals to the bit, in debug and in release builds and on every
//! target.

use super::network::{Network, Servo, through};
use super::*;

/// FNV-1a over the bits of everything that was asked of the arm in the end.
fn hash<T: Real>(config: &TeleopConfig) -> u64 {
    let servo = Servo { speed: 0.3, turn_speed: 1.0 };
    (0..40).fold(0xCBF2_9CE4_8422_2325, |hash, seed| {
        let goal = double(&through::<T>(config, Network::BAD, seed, 2.0, &servo).goal);
        goal.translation.iter().chain(goal.rotation.iter()).fold(hash, |hash, number| {
            number
                .to_bits()
                .to_le_bytes()
                .iter()
                .fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3))
        })
    })
}

#[test]
fn goals_are_pinned_to_the_bit() {
    let scaled = TeleopConfig {
        scale: 0.7,
        turning: crate::config::Turning::Scaled(0.6),
        robot_from_hand: Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        ..TeleopConfig::default()
    };
    let configs = [TeleopConfig::default(), TeleopConfig::paper(), scaled];
    let hashes = configs.map(|config| [hash::<f64>(&config), hash::<f32>(&config)]);
    let pinned = [
        ["6574790b7e6796c7", "7675209d474ed655"],
        ["fba82f105b2bca8c", "3e4336a81a918fa9"],
        ["3779aa95b56ca69e", "97caca1bc6900891"],
    ];
    assert_eq!(hashes.map(|pair| pair.map(|hash| std::format!("{hash:016x}"))), pinned);
}
