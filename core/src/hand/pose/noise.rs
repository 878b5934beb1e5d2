//! How far the centres may be believed: what is left of them after the fit tells how many times worse
//! than they say they are.

use super::PoseTracker;
use super::solve::Fit;

/// Frames over which the noise of the centres is judged.
const NOISE_MEMORY: f32 = 32.0;

/// The least that is left of the standard deviations that centres come with, however well they fit:
/// what they have in common does not show in what is left of them.
const MIN_NOISE: f32 = 0.5;

/// The most that centres are taken for worse than they say, in standard deviations.
pub(super) const MAX_NOISE: f32 = 100.0;

impl PoseTracker {
    /// Centres that are worse than they say are found out by what is left of them.
    pub(super) fn noise_follows(&mut self, fit: &Fit) {
        if fit.freedom > 0.0 {
            // few equations say less
            let share = fit.freedom / (fit.freedom + 10.0 * NOISE_MEMORY);
            let next = self.noise * self.noise * (1.0 + share * (fit.mean_square() - 1.0));
            self.noise = libm::sqrtf(next).clamp(MIN_NOISE, MAX_NOISE);
        }
    }
}
