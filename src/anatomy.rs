//! Named places on a head: landmarks, parts and measures.

use glam::{DVec3, Vec3};
use serde::Serialize;

use crate::blob::record::{Value, record};

/// A named triangle group (`skin`, `mouth cavity`, `left eyeball` ...).
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Part {
    /// The part's name.
    pub name: String,
    /// Its first triangle.
    pub first: u32,
    /// How many triangles it has.
    pub count: u32,
}

/// A named point of the surface, as weights on vertices that sum to 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Landmark {
    /// `ibug_00` to `ibug_67`, or an anatomical name.
    pub name: String,
    /// `(vertex, weight)` pairs; the weights sum to 1.
    pub stencil: Vec<(u32, f64)>,
}

impl Landmark {
    /// Where the point is on a face with these vertex positions (mm).
    pub fn position(&self, positions: &[Vec3]) -> Vec3 {
        self.stencil
            .iter()
            .map(|&(vertex, weight)| positions[vertex as usize] * weight as f32)
            .sum()
    }

    /// As [`Landmark::position`], summed in f64.
    pub fn place(&self, positions: &[Vec3]) -> DVec3 {
        let each = self.stencil.iter();
        each.map(|&(v, weight)| positions[v as usize].as_dvec3() * weight)
            .sum()
    }
}

/// So far below the points on brows (`ibug_17` to `ibug_26`) hair grows, mm, from the outer end inwards. The points are where
/// ICT-FaceKit has them, on its mean head 19 to 28 mm above the middles of the eyes, higher than on people: portraits that are
/// fitted by other points show hair 6 to 8 mm below them, and a head that is registered to a scan without them has them 4 mm above
/// the brows that are marked on it.
const BROW_HAIR_BELOW: [f32; 5] = [6.0, 6.0, 6.5, 7.0, 8.5];

/// Skin is no farther behind or before a point on a brow, mm: eyeballs and what is inside a head are.
const BESIDE_BROW_POINT: f32 = 15.0;

/// Where the hair of brows grows on a head that stands upright (y up), from its points `ibug_17` to `ibug_26` and all of its vertices,
/// mm: the middle of it, a point for each of these, straight below them on the skin.
pub fn brow_hair(points: [Vec3; 10], positions: &[Vec3]) -> [Vec3; 10] {
    let below = BROW_HAIR_BELOW.iter().chain(BROW_HAIR_BELOW.iter().rev());
    let mut hair = points;
    for (point, below) in hair.iter_mut().zip(below) {
        let own = *point;
        point.y -= below;
        let at = point.truncate();
        let near = positions
            .iter()
            .filter(|p| (p.z - own.z).abs() < BESIDE_BROW_POINT);
        let apart = |p: &Vec3| p.truncate().distance_squared(at);
        let skin = near.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        point.z = skin.map_or(own.z, |skin| skin.z);
    }
    hair
}

/// Something that can be measured on every face, in mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measure {
    /// What anthropometry calls it, such as `nose width`.
    pub name: String,
    /// Where it is measured, in words.
    pub description: String,
    /// What is measured.
    pub quantity: Quantity,
}

/// What a measure measures.
///
/// In a file it is a list of numbers, each quantity a kind and what belongs to it: `0 from to`,
/// `1 axis count of... count over...`, `2 count parts...` for a mean, `3 count parts...` for a
/// geometric mean, where parts are quantities. (A tree of named fields would need a reader three
/// times the size.)
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(into = "Vec<u32>")]
pub enum Quantity {
    /// The distance between two landmarks, mm.
    Distance {
        /// Index of the one landmark.
        from: u32,
        /// Index of the other.
        to: u32,
    },
    /// How far the mean of some landmarks lies from the mean of others along an axis of the head,
    /// mm; negative on the other side.
    Offset {
        /// Along which axis.
        axis: Axis,
        /// Indices of the landmarks.
        of: Vec<u32>,
        /// Indices of those that it is counted from.
        over: Vec<u32>,
    },
    /// The mean of several, such as left and right.
    Mean {
        /// What is averaged.
        mean: Vec<Quantity>,
    },
    /// The geometric mean of several: a size, of lengths across each other.
    GeometricMean {
        /// What is averaged; a negative one counts as 0.
        geometric_mean: Vec<Quantity>,
    },
}

impl From<Quantity> for Vec<u32> {
    fn from(quantity: Quantity) -> Self {
        let mut numbers = Vec::new();
        quantity.put(&mut numbers);
        numbers
    }
}

impl Value for Quantity {
    fn write(&self, out: &mut Vec<u8>) {
        Vec::<u32>::from(self.clone()).write(out);
    }

    fn read(bytes: &mut &[u8]) -> Option<Self> {
        let numbers = Vec::<u32>::read(bytes)?;
        let mut rest = numbers.as_slice();
        Self::take(&mut rest, MOST_LEVELS).filter(|_| rest.is_empty())
    }
}

record! {
    Part { name, first, count }
    Landmark { name, stencil }
    Measure { name, description, quantity }
}

/// The first of the numbers, which is taken off them.
fn next(numbers: &mut &[u32]) -> Option<u32> {
    let (first, rest) = numbers.split_first()?;
    *numbers = rest;
    Some(*first)
}

/// A count and as many numbers.
fn counted(numbers: &mut &[u32]) -> Option<Vec<u32>> {
    let count = next(numbers)? as usize;
    let (some, rest) = numbers.split_at_checked(count)?;
    *numbers = rest;
    Some(some.to_vec())
}

/// The root of some degree of a product of that many lengths. From a start that is too large,
/// Newton's method comes down to it.
fn root(product: f64, degree: usize) -> f64 {
    let power = |x: f64, count: usize| (0..count).fold(1.0, |p, _| p * x);
    let mut x = product.max(1.0);
    loop {
        let below = x - (x - product / power(x, degree - 1)) / degree as f64;
        if !(below < x) {
            return x;
        }
        x = below;
    }
}

impl Quantity {
    fn put(&self, numbers: &mut Vec<u32>) {
        match self {
            Quantity::Distance { from, to } => numbers.extend([0, *from, *to]),
            Quantity::Offset { axis, of, over } => {
                numbers.extend([1, *axis as u32]);
                for some in [of, over] {
                    numbers.push(some.len() as u32);
                    numbers.extend(some);
                }
            }
            Quantity::Mean { mean: parts }
            | Quantity::GeometricMean {
                geometric_mean: parts,
            } => {
                let kind = 2 + u32::from(matches!(self, Quantity::GeometricMean { .. }));
                numbers.extend([kind, parts.len() as u32]);
                parts.iter().for_each(|part| part.put(numbers));
            }
        }
    }

    fn take(numbers: &mut &[u32], levels: usize) -> Option<Self> {
        match next(numbers)? {
            0 => Some(Quantity::Distance {
                from: next(numbers)?,
                to: next(numbers)?,
            }),
            1 => Some(Quantity::Offset {
                axis: match next(numbers)? {
                    0 => Axis::X,
                    1 => Axis::Y,
                    2 => Axis::Z,
                    _ => return None,
                },
                of: counted(numbers)?,
                over: counted(numbers)?,
            }),
            kind @ (2 | 3) => {
                let below = levels.checked_sub(1)?;
                let count = next(numbers)?;
                let mut parts = Vec::new();
                for _ in 0..count {
                    parts.push(Self::take(numbers, below)?);
                }
                Some(if kind == 2 {
                    Quantity::Mean { mean: parts }
                } else {
                    Quantity::GeometricMean {
                        geometric_mean: parts,
                    }
                })
            }
            _ => None,
        }
    }
}

/// An axis of the head.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// To the subject's left.
    X,
    /// Up.
    Y,
    /// Out of the face.
    Z,
}

impl Axis {
    /// The unit vector.
    pub fn direction(self) -> DVec3 {
        match self {
            Axis::X => DVec3::X,
            Axis::Y => DVec3::Y,
            Axis::Z => DVec3::Z,
        }
    }
}

/// How a measure changes with each landmark that it depends on: `(landmark, mm a mm)`. A landmark
/// may come more than once; its changes add up.
pub type Gradient = Vec<(u32, DVec3)>;

/// Quantities of quantities: a size of means is two levels.
const MOST_LEVELS: usize = 3;

/// Lengths of a geometric mean: the steps to its root grow with the square of their number.
const MOST_LENGTHS: usize = 16;

impl Quantity {
    /// Its value where `place` says where a landmark is (mm), and how it changes with them.
    pub fn measure(&self, place: &dyn Fn(u32) -> DVec3) -> (f64, Gradient) {
        let mean_place = |some: &[u32]| -> DVec3 {
            some.iter().map(|&l| place(l)).sum::<DVec3>() / some.len() as f64
        };
        match self {
            Quantity::Distance { from, to } => {
                let across = place(*to) - place(*from);
                let along = across.normalize_or_zero();
                (across.length(), vec![(*from, -along), (*to, along)])
            }
            Quantity::Offset { axis, of, over } => {
                let axis = axis.direction();
                let each = |some: &[u32], sign: f64| {
                    let share = axis * (sign / some.len() as f64);
                    some.iter().map(|&l| (l, share)).collect::<Gradient>()
                };
                let value = (mean_place(of) - mean_place(over)).dot(axis);
                (value, [each(of, 1.0), each(over, -1.0)].concat())
            }
            Quantity::Mean { mean } => {
                let share = 1.0 / mean.len() as f64;
                let mut sum = (0.0, Gradient::new());
                for (value, gradient) in mean.iter().map(|q| q.measure(place)) {
                    sum.0 += share * value;
                    sum.1.extend(gradient.iter().map(|&(l, g)| (l, g * share)));
                }
                sum
            }
            Quantity::GeometricMean { geometric_mean } => {
                let each: Vec<_> = geometric_mean.iter().map(|q| q.measure(place)).collect();
                let power = 1.0 / each.len() as f64;
                let value = root(each.iter().map(|(v, _)| v.max(0.0)).product(), each.len());
                let mut gradient = Gradient::new();
                for (v, own) in each.iter().filter(|(v, _)| *v > 0.0) {
                    gradient.extend(own.iter().map(|&(l, g)| (l, g * (value * power / v))));
                }
                (value, gradient)
            }
        }
    }

    /// The distances and offsets that it is made of.
    pub fn terms(&self) -> Vec<&Quantity> {
        match self {
            Quantity::Distance { .. } | Quantity::Offset { .. } => vec![self],
            Quantity::Mean { mean: parts }
            | Quantity::GeometricMean {
                geometric_mean: parts,
            } => parts.iter().flat_map(Quantity::terms).collect(),
        }
    }

    /// Whether it can be measured where there are so many landmarks.
    pub(crate) fn is_sound(&self, landmarks: usize) -> bool {
        self.is_sound_to(landmarks, MOST_LEVELS)
    }

    fn is_sound_to(&self, landmarks: usize, levels: usize) -> bool {
        let there =
            |some: &[u32]| !some.is_empty() && some.iter().all(|&l| (l as usize) < landmarks);
        match self {
            Quantity::Distance { from, to } => there(&[*from, *to]),
            Quantity::Offset { of, over, .. } => there(of) && there(over),
            Quantity::Mean { mean: parts }
            | Quantity::GeometricMean {
                geometric_mean: parts,
            } => {
                let below = |q: &Quantity| q.is_sound_to(landmarks, levels - 1);
                let few = matches!(self, Quantity::Mean { .. }) || parts.len() <= MOST_LENGTHS;
                levels > 0 && !parts.is_empty() && few && parts.iter().all(below)
            }
        }
    }
}

impl Measure {
    /// The unit of all measures.
    pub const UNIT: &'static str = "mm";

    /// The measure of a face with these vertex positions, in mm.
    pub fn of(&self, landmarks: &[Landmark], positions: &[Vec3]) -> f64 {
        let place = |l: u32| landmarks[l as usize].place(positions);
        self.quantity.measure(&place).0
    }
}
