//! The sparse basis beside principal components, learned from few faces and from many (semantic
//! reshaping, section 5.1, Figs. 5 and 6).

use glam::DVec3;
use serde::Serialize;

use crate::fit::FitResult;
use crate::fit::head::template::Template;
use crate::fit::sparse::compare::{BASES, Trial, compare};
use crate::fit::sparse::{Kind, Settings};

/// Faces that are learned from: few, as most have who train a model, and the paper's number.
pub const TRAINING: [usize; 2] = [25, 100];
/// Other faces that each basis is tried on, where there are so many.
pub const TEST: usize = 100;
/// Fewer say nothing of others.
pub const FEWEST_TEST: usize = 20;
/// Numbers of components.
pub const COMPONENTS: [usize; 7] = [5, 15, 25, 35, 45, 55, 65];

/// The places among the bases of whole-face PCA of the faces alone, and of PCA and of the basis that semantic controls
/// are made of, that of regions, which both learn from the faces and their mirror images.
const ALONE: usize = 0;
const WHOLE: usize = 1;
const SPARSE: usize = 3;

/// Mean errors over some splits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bases {
    /// Faces that were learned from.
    pub training: usize,
    /// Other faces.
    pub test: usize,
    /// How many splits of the faces into the two.
    pub splits: u64,
    /// The numbers of components.
    pub components: Vec<usize>,
    /// One a basis.
    pub errors: Vec<Errors>,
}

/// Of one basis, mean distances between corresponding vertices of the face's skin, mm, by number of
/// components.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Errors {
    /// What the basis is.
    pub basis: String,
    /// On the faces it was learned from.
    pub training: Vec<f64>,
    /// On others.
    pub test: Vec<f64>,
    /// The least and the greatest of the splits, on others.
    pub range: Vec<[f64; 2]>,
}

/// How the sparse basis stands beside whole-face PCA of the same faces and mirror images.
pub struct Verdict {
    /// The least error that PCA reaches with any number of components, mm.
    pub best: f64,
    /// The same of a PCA of the faces alone, mm.
    pub best_alone: f64,
    /// From this number of components on the sparse basis is below that, if ever.
    pub below_from: Option<usize>,
    /// Its error with 65 components, as a part of the least of PCA.
    pub at_most: f64,
    /// Its error as a multiple of PCA's with as many components, `[components, multiple]`.
    pub beside: Vec<(usize, f64)>,
}

/// How many of so many faces are learned from, and how many others are tried, where both can be.
fn sets(faces: usize) -> impl Iterator<Item = [usize; 2]> {
    let set = move |training| [training, TEST.min(faces.saturating_sub(training))];
    (TRAINING.into_iter().map(set)).filter(|[_, test]| *test >= FEWEST_TEST)
}

/// Bases that one split of so many faces learns.
pub fn steps(faces: usize) -> u64 {
    (sets(faces).count() * COMPONENTS.len() * BASES.len()) as u64
}

/// Why so few faces are not learned from in one of the ways, or in any: a line each.
pub fn too_few(faces: usize) -> Vec<String> {
    let missing = TRAINING.into_iter().skip(sets(faces).count());
    let line = |training: usize| {
        format!(
            "{faces} people are too few to compare sparse bases that {training} are learned from: {} are the least, as \
             {FEWEST_TEST} others are tried",
            training + FEWEST_TEST
        )
    };
    missing.map(line).collect()
}

/// Compares bases over some splits of the faces, which are registered faces in any pose, mm, each of another person.
/// Calls `done` [`steps`] times a split. Of sets with too few faces there is nothing ([`too_few`]).
///
/// # Errors
/// When a basis cannot be learned.
pub fn bases(
    template: &Template,
    faces: &[Vec<DVec3>],
    splits: u64,
    done: impl Fn(),
) -> FitResult<Vec<Bases>> {
    let mut all = Vec::new();
    if splits < 1 {
        return Ok(all);
    }
    for [training, test] in sets(faces.len()) {
        let mut found = Vec::new();
        for split in 0..splits {
            let trial = Trial {
                train: training,
                test,
                seed: split.wrapping_add(1),
                components: COMPONENTS.to_vec(),
            };
            let kinds = [Kind::REGIONS, Kind::DISTANCE];
            let settings = Settings::default();
            found.push(compare(template, faces, &trial, &settings, kinds, &done)?);
        }
        let mean = |b: usize, i: usize, of: &dyn Fn(usize, usize, usize) -> f64| {
            (0..found.len()).map(|s| of(s, b, i)).sum::<f64>() / splits as f64
        };
        let ks = 0..COMPONENTS.len();
        let errors = BASES.iter().enumerate().map(|(b, basis)| Errors {
            basis: (*basis).into(),
            training: ks
                .clone()
                .map(|i| mean(b, i, &|s, b, i| found[s][b].train[i]))
                .collect(),
            test: ks
                .clone()
                .map(|i| mean(b, i, &|s, b, i| found[s][b].test[i]))
                .collect(),
            range: ks
                .clone()
                .map(|i| {
                    let each = found.iter().map(|split| split[b].test[i]);
                    [
                        each.clone().fold(f64::INFINITY, f64::min),
                        each.fold(0.0, f64::max),
                    ]
                })
                .collect(),
        });
        all.push(Bases {
            training,
            test,
            splits,
            components: COMPONENTS.to_vec(),
            errors: errors.collect(),
        });
    }
    Ok(all)
}

impl Bases {
    /// The sparse basis beside PCA.
    pub fn verdict(&self) -> Verdict {
        let (whole, sparse) = (&self.errors[WHOLE].test, &self.errors[SPARSE].test);
        let least = |errors: &[f64]| errors.iter().copied().fold(f64::INFINITY, f64::min);
        let best = least(whole);
        let below = |i: &usize| sparse[*i..].iter().all(|e| *e < best);
        let last = sparse.last().copied().unwrap_or(f64::NAN);
        Verdict {
            best,
            best_alone: least(&self.errors[ALONE].test),
            below_from: (0..sparse.len()).find(below).map(|i| self.components[i]),
            at_most: last / best,
            beside: (self.components.iter().zip(whole).zip(sparse))
                .map(|((&k, w), s)| (k, s / w))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bases_are_tried_on_as_many_others_as_there_are() {
        let all = |faces: usize| sets(faces).collect::<Vec<_>>();
        assert_eq!(all(300), [[25, 100], [100, 100]]);
        assert_eq!(all(200), [[25, 100], [100, 100]]);
        assert_eq!(all(120), [[25, 95], [100, 20]]);
        assert_eq!(all(119), [[25, 94]]);
        assert_eq!(all(45), [[25, 20]]);
        assert_eq!(all(44), [[0; 2]; 0]);
        assert_eq!(steps(300), 2 * steps(45));
        assert!(steps(45) > 0 && steps(10) == 0 && too_few(120).is_empty());
        let said = too_few(80);
        assert!(
            said.len() == 1
                && said[0].contains("80 people")
                && said[0].contains("120 are the least"),
            "{said:?}"
        );
        assert!(too_few(44)[0].contains("45 are the least"));
    }

    #[test]
    fn a_basis_that_learned_from_mirror_images_is_judged_by_pca_that_did() {
        let errors = |basis: &str, test: [f64; 3]| Errors {
            basis: basis.into(),
            training: Vec::new(),
            test: test.to_vec(),
            range: Vec::new(),
        };
        let tests = [
            [2.0, 1.5, 1.5],
            [2.0, 1.2, 1.0],
            [2.4, 1.3, 1.2],
            [2.4, 1.2, 0.8],
            [2.0, 1.1, 0.9],
        ];
        let set = Bases {
            training: 25,
            test: TEST,
            splits: 1,
            components: vec![5, 25, 65],
            errors: (BASES.iter().zip(tests))
                .map(|(b, t)| errors(b, t))
                .collect(),
        };
        let verdict = set.verdict();
        assert_eq!((verdict.best, verdict.best_alone), (1.0, 1.5));
        // Below 1.5 from 25 on, but not below what PCA makes of the same faces.
        assert_eq!(verdict.below_from, Some(65));
        assert_eq!(verdict.at_most, 0.8);
        assert_eq!(verdict.beside[2], (65, 0.8));
    }
}
