//! Who is on which face. Scans of one person are alike as no two people are: where some faces are held out from others,
//! all of a person's are, and what is found on them counts once; and a model is learned from people, not from scans.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::labels::Told;
use crate::Random;
use crate::fit::error::faces_are;
use crate::fit::{FitError, FitResult, counted};

/// Whom each of some faces is of: a number a face, which grows from 0 in the order of the people's first faces.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[serde(transparent)]
pub struct Persons {
    of: Vec<usize>,
}

impl Persons {
    /// So many faces, each of another person.
    pub fn each(faces: usize) -> Self {
        Self {
            of: (0..faces).collect(),
        }
    }

    /// Of the named faces those that are told to be of one person; all others are each of another.
    pub fn told(names: &[String], told: &Told) -> Self {
        let mut known = BTreeMap::new();
        let mut count = 0;
        let person = |name: &String| {
            let person = match told.person(name) {
                Some(person) => *known.entry(person).or_insert(count),
                None => count,
            };
            count = count.max(person + 1);
            person
        };
        Self {
            of: names.iter().map(person).collect(),
        }
    }

    /// How many faces there are.
    pub fn faces(&self) -> usize {
        self.of.len()
    }

    /// How many people.
    pub fn count(&self) -> usize {
        self.of.iter().max().map_or(0, |last| last + 1)
    }

    /// The number of a face's person.
    pub fn of(&self, face: usize) -> usize {
        self.of[face]
    }

    /// Whether each face is of another person.
    pub fn are_single(&self) -> bool {
        self.count() == self.faces()
    }

    /// How many they are, in words: "480 scans of 120 people", or where they are as many, by what they are called then,
    /// "120 faces".
    pub fn said(&self, single: &str) -> String {
        match self.are_single() {
            true if self.faces() == 1 => counted(1),
            true => format!("{} {single}", self.faces()),
            false if self.count() == 1 => format!("{} scans of 1 person", self.faces()),
            false => format!("{} scans of {} people", self.faces(), self.count()),
        }
    }

    /// The same with a verb: "1 face is", "480 scans of 120 people are".
    pub(in crate::fit) fn said_to_be(&self) -> String {
        match self.are_single() {
            true => faces_are(self.faces()),
            false => format!("{} are", self.said("faces")),
        }
    }

    /// Those of some of the faces, in that order.
    #[must_use]
    pub fn some(&self, faces: &[usize]) -> Self {
        let mut numbers = BTreeMap::new();
        let number = |&face: &usize| {
            let next = numbers.len();
            *numbers.entry(self.of[face]).or_insert(next)
        };
        Self {
            of: faces.iter().map(number).collect(),
        }
    }

    /// The faces of each person.
    fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups = vec![Vec::new(); self.count()];
        for (face, &person) in self.of.iter().enumerate() {
            groups[person].push(face);
        }
        groups
    }

    /// The first face of each person.
    pub fn one_each(&self) -> Vec<usize> {
        self.groups().iter().map(|faces| faces[0]).collect()
    }

    /// All faces of so many people, who are drawn at random.
    pub fn draw(&self, people: usize, seed: u64) -> Vec<usize> {
        let groups = self.groups();
        let drawn = shuffled(groups.len(), seed).into_iter().take(people);
        drawn.flat_map(|person| groups[person].clone()).collect()
    }

    /// Splits the faces at random into `count` test sets of nearly the same size, of which no two have a person in
    /// common. None is empty where there are as many people.
    pub fn folds(&self, count: usize, seed: u64) -> Vec<Vec<usize>> {
        let groups = self.groups();
        let order = shuffled(groups.len(), seed).into_iter();
        let mut order: Vec<&Vec<usize>> = order.map(|person| &groups[person]).collect();
        // Whoever has most faces goes first, so that the others make up for it. People of as many stay in random order.
        order.sort_by_key(|faces| Reverse(faces.len()));
        let mut folds = vec![Vec::new(); count];
        for faces in order {
            // The first of the smallest.
            if let Some(fold) = folds.iter_mut().min_by_key(|fold| fold.len()) {
                fold.extend(faces);
            }
        }
        folds
    }

    /// The mean of each person's faces, which lie on each other: all vertices, mm. Who has one face has it to the bit.
    ///
    /// So a person counts once however many scans there are, and what is unlike from scan to scan, which is none of
    /// the ways in which people differ, is left with its variance divided by their number.
    pub fn mean_faces(&self, faces: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
        let mean = |own: &Vec<usize>| {
            let mut mean = faces[own[0]].clone();
            for &other in &own[1..] {
                mean.iter_mut()
                    .zip(&faces[other])
                    .for_each(|(m, p)| *m += *p);
            }
            mean.iter_mut().for_each(|m| *m /= own.len() as f64);
            mean
        };
        self.groups().par_iter().map(mean).collect()
    }

    /// # Errors
    /// When they are those of another number of faces.
    pub fn check(&self, faces: usize) -> FitResult<()> {
        match self.faces() == faces {
            true => Ok(()),
            false => Err(FitError::Input(format!(
                "the persons are those of {} faces, and not of these {faces}",
                self.faces()
            ))),
        }
    }

    /// Of a value a face the mean of each person.
    pub fn means(&self, values: &[f64]) -> Vec<f64> {
        let mean = |faces: &Vec<usize>| {
            faces.iter().map(|&face| values[face]).sum::<f64>() / faces.len() as f64
        };
        self.groups().iter().map(mean).collect()
    }

    /// How much each face counts where each person counts once.
    pub fn weights(&self) -> Vec<f64> {
        let groups = self.groups();
        let weight = |&person: &usize| 1.0 / groups[person].len() as f64;
        self.of.iter().map(weight).collect()
    }
}

/// The numbers below `count` in random order.
pub fn shuffled(count: usize, seed: u64) -> Vec<usize> {
    let mut random = Random::new(seed);
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, (random.uniform() * (last + 1) as f64) as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(people: &[usize]) -> Persons {
        let all: Vec<usize> = (0..people.len()).collect();
        Persons { of: people.into() }.some(&all)
    }

    #[test]
    fn every_face_is_held_out_once() {
        let persons = Persons::each(23);
        let tests = persons.folds(5, 1);
        let mut all = tests.concat();
        all.sort_unstable();
        assert_eq!(all, (0..23).collect::<Vec<_>>());
        assert!(tests.iter().all(|test| (4..=5).contains(&test.len())));
        assert_ne!(tests, persons.folds(5, 2));
        // Of people with one face each every fifth of a random order, which is what published reports were made by.
        let order = shuffled(23, 1);
        for (fold, test) in tests.iter().enumerate() {
            let every: Vec<usize> = order.iter().copied().skip(fold).step_by(5).collect();
            assert_eq!(*test, every);
        }
        assert_eq!(persons.draw(10, 1), order[..10]);
        let values: Vec<f64> = (0..23).map(|i| 0.1 * f64::from(i)).collect();
        assert_eq!(persons.means(&values), values);
        assert_eq!(persons.weights(), [1.0; 23]);
    }

    #[test]
    fn a_person_is_held_out_whole() {
        // One has many faces, some have three, most one.
        let mut people = vec![0; 20];
        (1..6).for_each(|person| people.extend([person; 3]));
        people.extend(6..40);
        let persons = of(&people);
        assert_eq!((persons.faces(), persons.count()), (69, 40));
        for seed in 0..20 {
            let tests = persons.folds(5, seed);
            let mut all = tests.concat();
            all.sort_unstable();
            assert_eq!(all, (0..69).collect::<Vec<_>>());
            for (i, test) in tests.iter().enumerate() {
                let others = tests.iter().enumerate().filter(|(j, _)| *j != i);
                let others: Vec<usize> = others.flat_map(|(_, other)| other.clone()).collect();
                for &face in test {
                    assert!(others.iter().all(|&o| persons.of(o) != persons.of(face)));
                }
            }
            // 20 faces go together; the other 49 are shared by four.
            let mut sizes: Vec<usize> = tests.iter().map(Vec::len).collect();
            sizes.sort_unstable();
            assert_eq!(sizes, [12, 12, 12, 13, 20]);
        }
        let drawn = persons.draw(3, 1);
        assert_eq!(persons.some(&drawn).count(), 3);
        let whole = |&face: &usize| {
            let own = (0..69).filter(|&other| persons.of(other) == persons.of(face));
            own.clone().all(|other| drawn.contains(&other))
        };
        assert!(drawn.iter().all(whole));
    }

    #[test]
    fn the_faces_of_a_person_count_once() {
        let persons = of(&[7, 3, 7, 7, 5]);
        assert_eq!(persons, of(&[0, 1, 0, 0, 2]));
        assert_eq!(persons.one_each(), [0, 1, 4]);
        assert_eq!(
            persons.means(&[1.0, 10.0, 2.0, 3.0, 20.0]),
            [2.0, 10.0, 20.0]
        );
        let sum: f64 = persons.weights().iter().sum();
        // Three thirds and two ones, rounded.
        assert!((sum - 3.0).abs() < 1e-15, "{sum}");
        assert_eq!(persons.said("faces"), "5 scans of 3 people");
        assert_eq!(persons.some(&[1, 4]).said("faces"), "2 faces");
        assert_eq!(persons.some(&[4]).said("people"), "1 face");
        assert_eq!(persons.some(&[4, 2, 0]), of(&[0, 1, 1]));
        assert_eq!(Persons::default().count(), 0);
        let face = |x: f64| vec![DVec3::splat(0.1 * x), DVec3::X];
        let faces = [1.0, 10.0, 2.0, 3.0, 20.0].map(face);
        let means = persons.mean_faces(&faces);
        assert_eq!(means[1..], [face(10.0), face(20.0)]);
        assert!(means[0][0].distance(DVec3::splat(0.2)) < 1e-15 && means[0][1] == DVec3::X);
        persons.check(5).unwrap();
        let said = persons.check(4).unwrap_err().to_string();
        assert_eq!(said, "the persons are those of 5 faces, and not of these 4");
    }
}
