//! Sums of squares of six unknowns: of a symmetric matrix the lower triangle is enough.

use nalgebra::{Matrix6, Vector6};

/// Adds the lower triangle of `a b^t`, a multiple of `b` being `a`. Nothing is told of what is above the
/// diagonal: Cholesky's factorisation does not read it.
pub(super) fn add_lower(to: &mut Matrix6<f32>, a: &Vector6<f32>, b: &Vector6<f32>) {
    // by patterns: lengths that the compiler knows make straight code, a third of what a loop costs
    let columns: &mut [[f32; 6]; 6] = to.as_mut();
    let [c0, [_, c1 @ ..], [_, _, c2 @ ..], [_, _, _, c3 @ ..], [.., c4_4, c5_4], [.., c5]] = columns;
    let a: [f32; 6] = (*a).into();
    let [b0, b1, b2, b3, b4, b5] = (*b).into();
    let [_, a1 @ ..] = &a;
    let [_, _, a2 @ ..] = &a;
    let [_, _, _, a3 @ ..] = &a;
    let [.., a4, a5] = a;
    add(c0, &a, b0);
    add(c1, a1, b1);
    add(c2, a2, b2);
    add(c3, a3, b3);
    *c4_4 += a4 * b4;
    *c5_4 += a5 * b4;
    *c5 += a5 * b5;
}

fn add<const N: usize>(column: &mut [f32; N], a: &[f32; N], b: f32) {
    for (sum, a) in column.iter_mut().zip(a) {
        *sum += a * b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix6;

    #[test]
    fn the_lower_triangle_is_that_of_the_whole_product() {
        let b = Vector6::new(0.3, -1.7, 2.1, 0.01, 5.0, -0.6);
        let a = b * 0.37;
        let mut sum = Matrix6::from_fn(|row, column| (row * 7 + column) as f32 * 0.1);
        let expected = (sum + a * b.transpose()).lower_triangle();
        add_lower(&mut sum, &a, &b);
        assert_eq!(sum.lower_triangle(), expected);
    }
}
