//! Cubic B-splines over one axis, with an optional kink.
//!
//! Knots are uniform; the ends are clamped (four-fold), and a knot at a kink is three-fold, so that the spline is continuous there and its
//! slope may jump (de Boor, *A Practical Guide to Splines*, chapters IX and XI). The error of a smooth function falls
//! with the fourth power of the spacing, instead of the second as with hat functions on the same knots.

/// Splines whose basis adds up to one everywhere between the ends.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spline {
    start: f64,
    step: f64,
    pieces: Vec<SplinePiece>,
    /// Greville's abscissa of each coefficient: the coefficients of a linear function are its values there.
    greville: Vec<f64>,
}

/// The spline over one interval.
#[derive(Debug, Clone, PartialEq)]
struct SplinePiece {
    /// First of the four coefficients.
    first: usize,
    /// Their weights as polynomials of the fraction of the way through: the constant terms of all four, the linear ones, and so on.
    powers: [[f64; 4]; 4],
}

impl SplinePiece {
    /// Weights at a fraction of the way.
    #[inline]
    fn weights(&self, t: f64) -> [f64; 4] {
        let [a, b, c, d] = &self.powers;
        std::array::from_fn(|k| a[k] + t * (b[k] + t * (c[k] + t * d[k])))
    }

    /// Their derivatives by the fraction.
    fn slopes(&self, t: f64) -> [f64; 4] {
        let [_, b, c, d] = &self.powers;
        std::array::from_fn(|k| b[k] + t * (2.0 * c[k] + t * 3.0 * d[k]))
    }
}

/// The four coefficients at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weights {
    /// The first one; the others follow.
    pub(crate) first: usize,
    /// Their weights.
    pub(crate) value: [f64; 4],
}

impl Spline {
    /// Over `intervals` intervals of length `step` from `start`; `kink` is the number of an inner knot.
    pub(crate) fn new(start: f64, step: f64, intervals: usize, kink: Option<usize>) -> Self {
        let at = |k: usize| start + step * k as f64;
        let mut knots = vec![at(0); 3];
        // where each interval begins among the knots
        let mut begins = Vec::with_capacity(intervals);
        for k in 0..intervals {
            let times = if kink == Some(k) && k > 0 { 3 } else { 1 };
            knots.extend(std::iter::repeat_n(at(k), times));
            begins.push(knots.len() - 1);
        }
        knots.extend([at(intervals); 4]);
        let greville = knots.windows(3).skip(1).take(knots.len() - 4).map(|k| (k[0] + k[1] + k[2]) / 3.0).collect();
        let pieces = begins.iter().map(|b| SplinePiece { first: b - 3, powers: powers(&knots, *b) }).collect();
        Self { start, step, pieces, greville }
    }

    /// Number of coefficients.
    pub(crate) fn len(&self) -> usize {
        self.greville.len()
    }

    /// Greville's abscissae.
    pub(crate) fn greville(&self) -> &[f64] {
        &self.greville
    }

    /// Knots without their repetitions.
    pub(crate) fn knots(&self) -> Vec<f64> {
        (0..=self.pieces.len()).map(|k| self.start + self.step * k as f64).collect()
    }

    /// The piece that holds `x`, and the fraction of the way through it, beyond [0, 1] outside the ends.
    #[inline]
    fn place(&self, x: f64) -> (&SplinePiece, f64) {
        let along = (x - self.start) / self.step;
        let k = (along.max(0.0) as usize).min(self.pieces.len() - 1);
        (&self.pieces[k], along - k as f64)
    }

    /// Weights at `x`, held at the ends.
    pub(crate) fn held(&self, x: f64) -> Weights {
        let (piece, t) = self.place(x);
        Weights { first: piece.first, value: piece.weights(t.clamp(0.0, 1.0)) }
    }

    /// Weights at `x`, extended linearly beyond the ends.
    pub(crate) fn extended(&self, x: f64) -> Weights {
        let (piece, t) = self.place(x);
        if (0.0..=1.0).contains(&t) { Weights { first: piece.first, value: piece.weights(t) } } else { self.extended_with_slope(x).0 }
    }

    /// Weights at `x` and their derivative, extended linearly beyond the ends.
    pub(crate) fn extended_with_slope(&self, x: f64) -> (Weights, [f64; 4]) {
        let (piece, t) = self.place(x);
        let inside = t.clamp(0.0, 1.0);
        let slope = piece.slopes(inside).map(|s| s / self.step);
        let mut value = piece.weights(inside);
        let beyond = (t - inside) * self.step;
        if beyond != 0.0 {
            value.iter_mut().zip(slope).for_each(|(v, s)| *v += beyond * s);
        }
        (Weights { first: piece.first, value }, slope)
    }

    /// Coefficients of the spline that meets `f` at Greville's abscissae.
    pub(crate) fn through(&self, f: impl Fn(f64) -> f64) -> Vec<f64> {
        let n = self.len();
        let mut band = vec![vec![0.0; n + 1]; n];
        for (row, x) in band.iter_mut().zip(&self.greville) {
            let Weights { first, value } = self.held(*x);
            row[first..first + 4].copy_from_slice(&value);
            row[n] = f(*x);
        }
        // totally positive, so elimination without pivoting is stable (de Boor, chapter XIII)
        for k in 0..n {
            let pivot = band[k].clone();
            for row in band.iter_mut().take((k + 4).min(n)).skip(k + 1).filter(|r| r[k] != 0.0) {
                let factor = row[k] / pivot[k];
                row.iter_mut().zip(&pivot).skip(k).for_each(|(r, p)| *r -= factor * p);
            }
        }
        let mut c = vec![0.0; n];
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|j| band[k][j] * c[j]).sum();
            c[k] = (band[k][n] - known) / band[k][k];
        }
        c
    }
}

/// The four basis functions over the interval that begins at knot `b`, as polynomials of the fraction through it.
fn powers(knots: &[f64], b: usize) -> [[f64; 4]; 4] {
    let (from, to) = (knots[b], knots[b + 1]);
    // values at four even points, by Cox and de Boor's recursion, determine the cubic
    let samples: [[f64; 4]; 4] = std::array::from_fn(|s| {
        let x = from + (to - from) * s as f64 / 3.0;
        let mut n = [0.0; 4];
        n[0] = 1.0;
        for degree in 1..=3 {
            let mut saved = 0.0;
            for r in 0..degree {
                let (right, left) = (knots[b + r + 1] - x, x - knots[b + 1 + r - degree]);
                let share = if right + left > 0.0 { n[r] / (right + left) } else { 0.0 };
                n[r] = saved + right * share;
                saved = left * share;
            }
            n[degree] = saved;
        }
        n
    });
    let mut powers = [[0.0; 4]; 4];
    for r in 0..4 {
        let [y0, y1, y2, y3] = samples.map(|sample| sample[r]);
        let cubic =
            [y0, -5.5 * y0 + 9.0 * y1 - 4.5 * y2 + y3, 9.0 * y0 - 22.5 * y1 + 18.0 * y2 - 4.5 * y3, 4.5 * (y3 - y0) + 13.5 * (y1 - y2)];
        powers.iter_mut().zip(cubic).for_each(|(of_all, own)| of_all[r] = own);
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(spline: &Spline, c: &[f64], x: f64) -> f64 {
        let Weights { first, value } = spline.held(x);
        value.iter().zip(&c[first..]).map(|(w, c)| w * c).sum()
    }

    #[test]
    fn cubics_and_a_kink_are_reproduced() {
        let spline = Spline::new(-3.0, 0.5, 14, Some(6));
        assert_eq!(spline.len(), 14 + 3 + 2);
        let f = |x: f64| 0.3 * x * x * x - x + 2.0 + x.max(0.0) * (1.0 - x);
        let c = spline.through(f);
        for k in 0..=140 {
            let x = -3.0 + 0.05 * f64::from(k);
            assert!((value(&spline, &c, x) - f(x)).abs() < 1e-10, "{x}");
            let w = spline.held(x).value;
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && w.iter().all(|w| *w >= -1e-12), "{x}: {w:?}");
        }
    }

    #[test]
    fn a_ramp_has_its_own_values_as_coefficients() {
        let spline = Spline::new(-2.0, 0.5, 12, Some(4));
        let c: Vec<f64> = spline.greville().iter().map(|x| x.max(0.0)).collect();
        for k in 0..=60 {
            let x = -2.0 + 0.1 * f64::from(k);
            assert!((value(&spline, &c, x) - x.max(0.0)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn beyond_the_ends_it_goes_on_straight_and_slopes_are_those_of_finite_differences() {
        let spline = Spline::new(0.0, 0.25, 4, None);
        let c = spline.through(|x| x * x);
        let at = |x: f64| {
            let (w, s) = spline.extended_with_slope(x);
            let sum = |weights: [f64; 4]| weights.iter().zip(&c[w.first..]).map(|(w, c)| w * c).sum::<f64>();
            (sum(w.value), sum(s))
        };
        assert!((at(1.5).0 - 2.0).abs() < 1e-10 && (at(-1.0).0).abs() < 1e-10);
        for x in [0.1, 0.4, 0.77, 1.2] {
            assert!((at(x).1 - (at(x + 1e-6).0 - at(x - 1e-6).0) / 2e-6).abs() < 1e-6);
        }
    }

    #[test]
    fn the_error_of_a_bump_falls_with_the_fourth_power_of_the_spacing() {
        let f = |x: f64| (-(x - 0.45).powi(2) / 0.0225).exp();
        let worst = |intervals: usize| {
            let spline = Spline::new(0.0, 1.0 / intervals as f64, intervals, None);
            let c = spline.through(f);
            (0..=1000).map(|k| f64::from(k) / 1000.0).map(|x| (value(&spline, &c, x) - f(x)).abs()).fold(0.0, f64::max)
        };
        assert!(worst(32) / worst(16) < 1.0 / 12.0);
    }
}
