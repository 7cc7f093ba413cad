//! Is the population Gaussian? And how far is a slider that follows the population from one that
//! supposes it is?

use serde::Serialize;

/// How the coefficients of one mode are distributed over the training faces.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distribution {
    /// The control that the mode has.
    pub control: String,
    /// The third standardised moment: 0 for a normal distribution.
    pub skewness: f64,
    /// The fourth, less 3: 0 for a normal distribution.
    pub excess_kurtosis: f64,
    /// The largest distance between the empirical distribution function and the normal one of the
    /// same mean and variance (Kolmogorov, Smirnov): how far a slider of percentiles is from one
    /// that supposes a normal distribution, 0..=1.
    pub distance: f64,
    /// The coefficients in increasing order, in standard deviations.
    #[serde(skip)]
    pub sorted: Vec<f64>,
}

/// All coefficients of a model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Normality {
    /// Training faces.
    pub faces: usize,
    /// The distance that five in a hundred samples of this size from a normal distribution exceed
    /// (Lilliefors 1967: 0.886 / sqrt(n) for n over 30; below, what the same tables have, by a fit within 1 %).
    pub critical: f64,
    /// How many of the coefficients exceed it.
    pub exceeding: usize,
    /// One a coefficient.
    pub coefficients: Vec<Distribution>,
}

/// Looks at the columns of `coefficients` (a row a face), which belong to `controls`.
pub fn normality(controls: &[String], coefficients: &[Vec<f64>]) -> Normality {
    let n = coefficients.len();
    let critical = critical(n);
    let of = |(i, control): (usize, &String)| {
        distribution(control, coefficients.iter().map(|row| row[i]).collect())
    };
    let coefficients: Vec<Distribution> = controls.iter().enumerate().map(of).collect();
    Normality {
        faces: n,
        critical,
        exceeding: coefficients
            .iter()
            .filter(|d| d.distance > critical)
            .count(),
        coefficients,
    }
}

/// The distance that five in a hundred normal samples of `n` exceed.
fn critical(n: usize) -> f64 {
    let n = n as f64;
    match n > 30.0 {
        true => 0.886 / n.sqrt(),
        false => 0.895 / ((n + 0.83) / n.sqrt() - 0.01),
    }
}

fn distribution(control: &str, mut values: Vec<f64>) -> Distribution {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let moment = |power: i32| values.iter().map(|v| (v - mean).powi(power)).sum::<f64>() / n;
    let deviation = moment(2).sqrt();
    let (skewness, kurtosis) = (
        moment(3) / deviation.powi(3),
        moment(4) / deviation.powi(4) - 3.0,
    );
    // The tables of the distance are of samples in the deviation that an unknown mean leaves unbiased.
    let unbiased = deviation * (n / (n - 1.0)).sqrt();
    values.iter_mut().for_each(|v| *v = (*v - mean) / unbiased);
    let distance = values.iter().enumerate().fold(0.0_f64, |most, (i, &v)| {
        let p = cumulative(v);
        let (below, above) = (i as f64 / n, (i as f64 + 1.0) / n);
        most.max(p - below).max(above - p)
    });
    Distribution {
        control: control.to_owned(),
        skewness,
        excess_kurtosis: kurtosis,
        distance,
        sorted: values,
    }
}

/// The normal distribution function, within 7.5e-8 (Abramowitz and Stegun 26.2.17).
pub fn cumulative(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let poly = t
        * (0.319_381_530
            + t * (-0.356_563_782
                + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = (-x * x / 2.0).exp() / std::f64::consts::TAU.sqrt() * poly;
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// The inverse of [`cumulative`] for a `p` between 0 and 1, by bisection.
pub fn quantile(p: f64) -> f64 {
    let (mut low, mut high) = (-10.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cumulative(middle) < p {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn the_normal_distribution_is_the_tables() {
        for (x, p) in [
            (0.0, 0.5),
            (1.0, 0.841_344_75),
            (-1.96, 0.024_997_9),
            (3.0, 0.998_650_1),
        ] {
            assert!((cumulative(x) - p).abs() < 1e-6);
            assert!((quantile(p) - x).abs() < 1e-4);
        }
    }

    #[test]
    fn five_in_a_hundred_normal_samples_exceed_the_critical_distance() {
        let mut random = Random::new(5);
        for n in [5, 12, 30, 31] {
            const SAMPLES: u32 = 20_000;
            let mut sample = || distribution("", (0..n).map(|_| random.normal()).collect());
            let over = (0..SAMPLES)
                .filter(|_| sample().distance > critical(n))
                .count();
            let part = over as f64 / f64::from(SAMPLES);
            println!("{n}: {:.2} %", 100.0 * part);
            // A standard error is 0.0015, and the fits are within 2 % of the distance, which is 0.006.
            assert!((part - 0.05).abs() < 0.01, "{n}: {part}");
        }
    }

    #[test]
    fn normal_numbers_pass_and_lognormal_ones_do_not() {
        let mut random = Random::new(4);
        let rows: Vec<Vec<f64>> = (0..300)
            .map(|_| {
                let x = random.normal();
                vec![x, (0.8 * x).exp()]
            })
            .collect();
        let found = normality(&["normal".into(), "lognormal".into()], &rows);
        assert_eq!(found.exceeding, 1);
        assert!(found.coefficients[0].distance < found.critical);
        assert!(found.coefficients[1].skewness > 1.0);
    }
}
