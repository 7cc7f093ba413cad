//! What a control does, in words: eigenmeshes have no names of their own.

use super::FitResult;
use super::measures::MEASURES;
use crate::FaceModel;
use crate::model::ModelParts;

/// A measure is worth a word when one sigma of the control moves it by this part of its own
/// standard deviation in the population.
const WORTH_A_WORD: f64 = 0.3;
const MOST_WORDS: usize = 3;

/// Describes every control by the measures that it moves most: what the face has when the slider
/// is at its right end, strongest first. A control that moves none is left without a description.
///
/// `coefficients` are those of the population in sigmas, a row a face.
///
/// # Errors
/// When the parts are not a sound model.
pub fn describe(parts: &mut ModelParts, coefficients: &[Vec<f64>]) -> FitResult<()> {
    let model = FaceModel::parse(&parts.write()?)?;
    let mut face = model.face();
    let mut measured = |coefficients: &[f32]| -> FitResult<Vec<f64>> {
        face.set_coefficients(coefficients)?;
        Ok(MEASURES
            .iter()
            .map(|m| face.measure(m.name))
            .collect::<Result<_, _>>()?)
    };
    let population = coefficients
        .iter()
        .map(|row| measured(&row.iter().map(|&c| c as f32).collect::<Vec<_>>()))
        .collect::<FitResult<Vec<_>>>()?;
    let deviation = |m: usize| {
        let n = population.len() as f64;
        let mean = population.iter().map(|row| row[m]).sum::<f64>() / n;
        (population
            .iter()
            .map(|row| (row[m] - mean).powi(2))
            .sum::<f64>()
            / n)
            .sqrt()
    };
    let deviations: Vec<f64> = (0..MEASURES.len()).map(deviation).collect();
    for control in &mut parts.controls {
        let mut at = |amount: f32| {
            let mut c = vec![0.0; coefficients[0].len()];
            control
                .direction
                .iter()
                .for_each(|&(i, change)| c[i as usize] = amount * change);
            measured(&c)
        };
        // Over two sigmas to both sides: what a person sees, not the slope at the mean.
        let (more, less) = (at(2.0)?, at(-2.0)?);
        let mut moved: Vec<(f64, &str)> = (0..MEASURES.len())
            .map(|m| {
                let amount = (more[m] - less[m]) / 4.0 / deviations[m].max(1e-9);
                (amount, MEASURES[m].more_and_less[usize::from(amount < 0.0)])
            })
            .filter(|(amount, _)| amount.abs() >= WORTH_A_WORD)
            .collect();
        moved.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        let words: Vec<&str> = moved.iter().take(MOST_WORDS).map(|m| m.1).collect();
        control.description = words.join(", ");
    }
    Ok(())
}
