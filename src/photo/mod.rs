//! A face from a photo: camera and shape from 68 points (semantic reshaping, section 4.1), and the
//! light on it ([`Light`], section 4.2). Then the photo can change as its face does ([`Edit`]), and the
//! head can wear it ([`Texture`]).
//!
//! The unknowns are the pose (rotation, translation), the focal length, all coefficients of the
//! population and the weights of expressions. Minus twice the logarithm of their probability is
//!
//! E = E_lan + E_c + E_reg, with
//! E_lan = sum over points of (distance from the projected point / its standard deviation)^2,
//! E_c what the pixels tell of it if they are given (`appearance`), and
//! E_reg = |z|^2 + sum 2 a b log(1 + e / b) + ((log f - log f_0) / sigma_f)^2 - 2 n_eff (log Z - log f),
//!
//! with z the coefficients in a basis in which they are independent and standard normal,
//! e >= 0 the expression weights (few of which are shown: the prior is sparse), f the focal length and Z the distance of the face. It is minimised
//! by Gauss-Newton steps on iteratively reweighted least squares.
//!
//! The last term is not in the paper. The most probable pose is that of the *marginal* distribution
//! over shapes, which has a factor det(H)^-1/2 of the curvature H in z that the joint one lacks: a
//! head that is seen smaller is told less about, so more of its shapes will do. To first order in
//! the size of the image of the head, which is as f / Z, it is that term, with n_eff = k - tr(H^-1)
//! the number of the k coefficients that points and pixels determine. Without it heads come out 3 % too
//! small: when the head shrinks and comes nearer its image is the same, and the prior prefers less of
//! every shape.
//!
//! Where there are other photos of the person, E_reg has what they tell of z besides: E_lan of each, and E_c, to second
//! order, marginal over its pose, expressions, light and albedo.

mod albedo;
mod appearance;
mod camera;
mod contour;
mod cover;
mod curtains;
mod gaze;
mod grain;
mod iris;
mod light;
mod looks;
mod pixels;
pub mod raster;
mod reshape;
mod shape;
mod sight;
mod skin;
mod solver;
mod start;
mod surface;
mod teeth;
mod texture;
mod tones;

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};

pub use camera::Camera;
pub use light::{Detail, HARMONICS, Image, Light};
pub use looks::{Hair, Looks};
pub use reshape::{Edit, Field};
pub use texture::{Texture, View};

use crate::{Error, Expressions, FaceModel, Result};
use contour::JAW;
use shape::{Points, Stencil};
use solver::{Known, Observed, State, Terms};
use surface::Surface;

/// How many points a face has in the scheme of iBUG.
pub const POINTS: usize = 68;

/// The longer side of film, mm: a focal length without a sensor's size is told as if for this.
const FILM: f64 = 36.0;
/// What people are photographed with: 50 mm on film, by a factor of 1.42 (one standard deviation)
/// more or less. Within two lie the wide cameras of telephones (24 mm) and portrait lenses (100 mm).
const FOCAL: (f64, f64) = (50.0, 0.35);
/// The standard deviation of the logarithm of a focal length that is given. Programs round it, and
/// crops by stabilisation are a few per cent.
const KNOWN_FOCAL: f64 = 0.03;
/// Farther outside of the image than so many times its size no point of a face in it is.
const OUTSIDE: f64 = 2.0;

/// A photo, as far as a fit asks.
#[derive(Debug, Clone, Copy)]
pub struct Photo<'a> {
    /// The width, px.
    pub width: u32,
    /// The height, px.
    pub height: u32,
    /// The 68 points of iBUG (Sagonas et al. 2013), px, in their order: the subject's right jaw
    /// first. x to the right and y down, from the upper left corner. They are where the model's landmarks are: those
    /// of brows some 7 mm above their hair ([`brow_hair`](crate::anatomy::brow_hair)).
    pub points: &'a [[f64; 2]],
    /// The focal length in px, if it is known: that of EXIF as if for film, over the 43.3 mm of its
    /// diagonal, times that of the image, unless it was cut.
    pub focal: Option<f64>,
    /// The standard deviation of the points along each axis, px, if it is known. Otherwise it is
    /// estimated.
    pub noise: Option<f64>,
    /// That of the 17 points of the jaw across the face's outline, px, if it is known and another: detectors
    /// tell where a face ends less well than where its eyes are.
    pub jaw: Option<f64>,
    /// The middles of the irises of the subject's right and left eye, px, if they are seen: where these look is told by
    /// them, and what lids do is told apart from it. Points alone say nothing of it.
    pub irises: Option<[[f64; 2]; 2]>,
    /// Other photos of the same person, who may look elsewhere there and show another expression: what their points tell
    /// of the face counts, too. Others of theirs are not asked for.
    pub others: &'a [Photo<'a>],
    /// The pixels of one of the others, if they are to tell of the face where those of the photo itself do
    /// ([`Fitter::fit_pixels`]).
    pub image: Option<Image<'a>>,
}

/// How well a fit tells the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// The root mean square of the distances between the 51 points inside of the face's outline, as
    /// given and as fitted, px.
    pub rms_px: f64,
    /// The same at the face, mm.
    pub rms_mm: f64,
    /// How unusual the face is: the length of its independent coefficients, as a part of what is
    /// expected of as many as are determined. Of people it is about 1.
    pub unusual: f64,
    /// How many of the coefficients the points determine, with those of other photos, and the pixels if they told any.
    pub determined: f64,
    /// The angle between where the face looks and the direction of the camera, radians.
    pub away: f64,
}

/// More than this is no face that was badly marked, mm. Five times what detectors are off.
const WORST_RMS: f64 = 8.0;
/// Nobody is so unusual. Portraits of people who smile, with a detector's points, have 1.8 to 2.1, and up
/// to 2.5 when a fit knows no expressions: what detectors mark a little elsewhere than registrations
/// counts as shape. It does not tell drawings: those of large eyes, small noses and pointed chins have
/// 1.7 to 2.2, too, and points that are off by no more than bad detectors' are.
const MOST_UNUSUAL: f64 = 2.6;
/// A face that looks farther away has no points that are seen: 110 degrees, a lost profile.
const FARTHEST_AWAY: f64 = 110.0 / 180.0 * std::f64::consts::PI;

impl Quality {
    /// Why the points should not be taken for a face's, in a sentence; `None` when they may.
    pub fn refusal(&self) -> Option<String> {
        if !(self.rms_mm <= WORST_RMS) {
            let off = self.rms_mm.round();
            return Some(format!(
                "These points are no face's: the nearest face is {off} mm off"
            ));
        }
        if !(self.away <= FARTHEST_AWAY) {
            return Some(
                "These points are a face's from behind: are left and right exchanged?".into(),
            );
        }
        (!(self.unusual <= MOST_UNUSUAL))
            .then(|| "These points are no face's: nobody has such proportions".into())
    }
}

/// A face that was fitted to a photo.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The coefficients, for [`crate::Face::set_coefficients`]: these are on a face's grid.
    pub coefficients: Vec<f32>,
    /// The face's [`crate::Face::code`].
    pub code: String,
    /// The weight of each expression, 0..=1; empty when none were given.
    pub expression: Vec<f64>,
    /// The camera, in the frame of the model's heads.
    pub camera: Camera,
    /// From where each of the 68 points is given to where it is on the fitted face, px; jaw points
    /// are where the face's outline is seen.
    pub residuals: Vec<DVec2>,
    /// How well it fits.
    pub quality: Quality,
    /// What the photo's pixels told; `None` when none were given, or they told nothing.
    pub appearance: Option<Appearance>,
    /// How the other photos of the person were taken, in their order.
    pub others: Vec<Shot>,
}

/// How another photo of a fitted face was taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// The camera, in the frame of the model's heads.
    pub camera: Camera,
    /// The weight of each expression there, 0..=1.
    pub expression: Vec<f64>,
    /// As [`Fit::residuals`], of the points of that photo.
    pub residuals: Vec<DVec2>,
    /// As [`Quality::rms_px`].
    pub rms_px: f64,
    /// As [`Quality::rms_mm`].
    pub rms_mm: f64,
}

impl Shot {
    /// `None` when a part of the face is behind the camera.
    fn of(observed: &Observed, state: &State, terms: &Terms) -> Option<Self> {
        let residuals = observed.residuals(state)?;
        let [rms_px, rms_mm] = inner_rms(&residuals, state);
        Some(Self {
            camera: state.pose.camera(),
            expression: state.unknowns[terms.coefficients..].to_vec(),
            residuals,
            rms_px,
            rms_mm,
        })
    }
}

/// How far the points inside of the outline are off, px and mm at the face.
fn inner_rms(residuals: &[DVec2], state: &State) -> [f64; 2] {
    let inner = &residuals[JAW..];
    let square: f64 = inner.iter().map(|r| r.length_squared()).sum();
    let px = (square / inner.len() as f64).sqrt();
    [px, px * (state.pose.log_depth - state.pose.log_focal).exp()]
}

/// What is found with pixels where something is known.
struct Knowing {
    fit: Fit,
    /// The face's independent coefficients: those that points are told by, or all.
    coefficients: Vec<f64>,
    /// What the photo tells others, if that was asked and its pixels tell any.
    tells: Option<Known>,
}

/// What a photo's pixels told of a face's shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Appearance {
    /// How far the skin that was believed is off its albedo times the shading: the root mean square of the
    /// difference as a part of that, after the last step but one.
    pub rms: f64,
    /// How many patches of skin were compared.
    pub patches: usize,
}

/// A face goes so much of the way from what the points tell of it to what the pixels do. What shading tells wrongly is
/// not independent from pixel to pixel, and its energy believes it too much: of 100 people of ICT-FaceKit (seeds from
/// 9050) five become worse with all of the way and three with this, whose mean error is the same to 0.6 %.
const BELIEVED: f64 = 0.8;

/// Photos of one person are fitted so many times in turn, each with what the others tell: to second order about where all
/// of them put the face. In turn the same face comes of all of them then, but for a thousandth of what each changes.
const TURNS: usize = 3;

/// Weights of expressions below this are not shown: no vertex moves by a tenth of a mm.
const SHOWN: f64 = 2e-3;

/// Which of some expressions are shown, from their weights.
fn expression_shown(weights: &[f64]) -> Vec<usize> {
    (0..weights.len()).filter(|&e| weights[e] > SHOWN).collect()
}

/// Fits faces of a model to photos.
#[derive(Debug, Clone)]
pub struct Fitter {
    model: FaceModel,
    expressions: Option<Expressions>,
    /// The 68 points, then those of the jaw's paths but for their first.
    points: Points,
    /// The same with all axes.
    whole: Points,
    /// For pixels; see [`Fitter::prepare`].
    surface: OnceLock<Arc<Surface>>,
    /// For each jaw point its path, as indices into the points.
    paths: Vec<Vec<usize>>,
    /// The middle of the 68 points on the mean head.
    pivot: DVec3,
}

impl Fitter {
    /// Prepares fits of a model's faces, at rest or with expressions.
    ///
    /// # Errors
    /// When the model lacks one of the 68 landmarks, or describes no people.
    pub fn new(model: &FaceModel, expressions: Option<&Expressions>) -> Result<Self> {
        if model.parts().population() == 0 {
            return Err(Error::Mismatch(
                "a photo needs a model of people, and this is one head".into(),
            ));
        }
        let mut stencils: Vec<Stencil> = shape::ibug(model)?;
        let mut paths = Vec::new();
        for (i, path) in contour::paths(model, &stencils).into_iter().enumerate() {
            let first = stencils.len();
            stencils.extend(path.into_iter().skip(1));
            paths.push(std::iter::once(i).chain(first..stencils.len()).collect());
        }
        let [points, whole] = Points::new(model, expressions, &stencils);
        let pivot = points.mean[..POINTS].iter().sum::<DVec3>() / POINTS as f64;
        Ok(Self {
            model: model.clone(),
            expressions: expressions.cloned(),
            points,
            whole,
            surface: OnceLock::new(),
            paths,
            pivot,
        })
    }

    /// The model whose faces are fitted.
    pub fn model(&self) -> &FaceModel {
        &self.model
    }

    /// The face, camera and expression that a photo's points tell. The same points give the same
    /// fit, whatever was fitted before.
    ///
    /// With other photos of the person the face is the most probable one of all of them, where the points of each have
    /// a pose, a focal length, expressions and a noise of their own.
    ///
    /// # Errors
    /// When there are not 68 points, one is not a number or far outside of the image, they lie on a
    /// line, or the image or the focal length is not above 0.
    pub fn fit(&self, photo: &Photo) -> Result<Fit> {
        let seen = checked(photo)?;
        let observed = self.observed(&self.points, &seen);
        let (told, others) = self.told(photo)?;
        let known = Known::all(told.iter().skip(1).flatten());
        let (state, _) = self.solve(photo, None, &observed, known)?;
        let fit = self.finish(&observed, state, &self.points.basis, None);
        Ok(Fit {
            others,
            ..fit.ok_or_else(nobody)?
        })
    }

    /// The same from a photo's points and its pixels, which tell the shape by its shading, E_c
    /// (`appearance`), and from those of its others that have an image. When they do not, because too
    /// little of the face is seen or is lit, or what they say disagrees with the points, the fit is that
    /// of the points, and its [`Fit::appearance`] is `None`.
    ///
    /// # Errors
    /// As [`Fitter::fit`], and when an image has another size than its photo.
    pub fn fit_pixels(&self, photo: &Photo, image: &Image) -> Result<Fit> {
        self.fit_pixels_telling(photo, image, &mut |_| ())
    }

    /// The same, which tells the part of its steps that are done after each of them: above 0, at last 1.
    /// A fit that pixels tell nothing ends sooner.
    ///
    /// # Errors
    /// As [`Fitter::fit_pixels`].
    pub fn fit_pixels_telling(
        &self,
        photo: &Photo,
        image: &Image,
        told: &mut dyn FnMut(f64),
    ) -> Result<Fit> {
        let each = || photo.others.iter().filter_map(|o| Some((o, o.image?)));
        for (photo, image) in std::iter::once((photo, *image)).chain(each()) {
            image.check_size([photo.width, photo.height])?;
        }
        let (mut of_all, mut others) = self.told(photo)?;
        let count = 1 + each().count();
        let mut done = 0;
        let mut part = |part: f64, done: usize| told((done as f64 + part) / count as f64);
        for (i, other) in photo.others.iter().enumerate() {
            let Some(image) = other.image else { continue };
            let rest = of_all.iter().enumerate().filter(|(j, _)| *j != i + 1);
            let known = Known::all(rest.filter_map(|(_, told)| told.as_ref()));
            let own = self.fit_knowing(known, other, &image, true, &mut |p| part(p, done));
            done += 1;
            // Where its pixels tell nothing its points still do.
            if let Ok(Knowing { tells, .. }) = own
                && tells.is_some()
            {
                of_all[i + 1] = tells;
            }
        }
        let known = Known::all(of_all.iter().skip(1).flatten());
        let found = self.fit_knowing(known, photo, image, false, &mut |p| part(p, done))?;
        for (other, shot) in photo.others.iter().zip(&mut others) {
            // Of a face that is another than their points alone told.
            let seen = checked(other)?;
            let observed = self.observed(&self.whole, &seen);
            let known = Known::exactly(&found.coefficients);
            let solved = self.solve(other, other.image.as_ref(), &observed, Some(known));
            let of_it = solved
                .ok()
                .and_then(|(state, terms)| Shot::of(&observed, &state, &terms));
            if let Some(of_it) = of_it {
                *shot = of_it;
            }
        }
        Ok(Fit {
            others,
            ..found.fit
        })
    }

    /// What a photo's points and pixels tell with what is known, and, if that is asked, what they tell others.
    fn fit_knowing(
        &self,
        known: Option<Known>,
        photo: &Photo,
        image: &Image,
        asked: bool,
        told: &mut dyn FnMut(f64),
    ) -> Result<Knowing> {
        let seen = checked(photo)?;
        let observed = self.observed(&self.points, &seen);
        let of_all = known;
        let known = (of_all.as_ref()).and_then(|known| known.of_first(self.points.basis.ncols()));
        let (state, terms) = self.solve(photo, Some(image), &observed, known)?;
        let fit = self.finish(&observed, state.clone(), &self.points.basis, None);
        let fit = fit.ok_or_else(nobody)?;
        let by_points = Knowing {
            fit,
            coefficients: state.unknowns[..terms.coefficients].to_vec(),
            tells: None,
        };
        // Points that are no face's have no pixels that are.
        if by_points.fit.quality.refusal().is_some() {
            return Ok(by_points);
        }
        let observed = self.observed(&self.whole, &seen);
        let first = self.points.basis.ncols();
        let terms = Terms {
            coefficients: self.whole.basis.ncols(),
            known: of_all,
            ..terms
        };
        let mut start = state;
        let more = std::iter::repeat_n(0.0, terms.coefficients - first);
        start.unknowns.splice(first..first, more);
        let comparison = appearance::Comparison {
            model: &self.model,
            surface: self.surface(),
            observed: &observed,
            terms: &terms,
            basis: &self.whole.basis,
            expressions: self.expressions.as_ref().map_or(&[], |e| e.list()),
        };
        let Some(mut refined) = comparison.refine(image, &start, asked, told) else {
            return Ok(by_points);
        };
        let tells = (refined.told.as_ref())
            .and_then(|pixels| solver::told(&observed, &terms, &refined.state, Some(pixels)));
        let coefficients = refined.state.unknowns[..terms.coefficients].iter_mut();
        for (pixels, &points) in coefficients.zip(&start.unknowns) {
            *pixels = points + BELIEVED * (*pixels - points);
        }
        let appearance = Appearance {
            rms: refined.rms,
            patches: refined.patches,
        };
        let coefficients = refined.state.unknowns[..terms.coefficients].to_vec();
        let better = self.finish(
            &observed,
            refined.state,
            &self.whole.basis,
            Some(appearance),
        );
        // A face that nobody has is worse than the points' own, and so is one that is not before the camera.
        Ok(match better {
            Some(fit) if fit.quality.refusal().is_none() => Knowing {
                fit,
                coefficients,
                tells,
            },
            _ => by_points,
        })
    }

    /// Prepares what fits with pixels need, which the first of them would do otherwise.
    pub fn prepare(&self) {
        self.surface();
    }

    fn surface(&self) -> &Surface {
        self.surface
            .get_or_init(|| Arc::new(Surface::new(&self.model)))
    }

    fn observed<'a>(&'a self, points: &'a Points, seen: &'a [DVec2]) -> Observed<'a> {
        Observed {
            points,
            paths: &self.paths,
            seen,
        }
    }

    /// The expression that opens the jaw, and how far teeth speak against it.
    fn jaw_shut(&self, image: &Image, seen: &[DVec2]) -> Option<(usize, f64)> {
        let all = self.expressions.as_ref()?.list();
        let jaw = all.iter().position(|e| e.name == "jawOpen")?;
        Some((jaw, teeth::shut(image, seen)))
    }

    /// What the points of a photo tell of the face and then those of its others, and how those were taken.
    fn told(&self, photo: &Photo) -> Result<(Vec<Option<Known>>, Vec<Shot>)> {
        if photo.others.is_empty() {
            return Ok((Vec::new(), Vec::new()));
        }
        let photos: Vec<&Photo> = std::iter::once(photo).chain(photo.others).collect();
        let seen: Vec<Vec<DVec2>> = (photos.iter().map(|p| checked(p))).collect::<Result<_>>()?;
        let mut told: Vec<Option<Known>> = vec![None; photos.len()];
        let mut shots = Vec::with_capacity(photos.len());
        for _ in 0..TURNS {
            shots.clear();
            for i in 0..photos.len() {
                told[i] = None;
                let observed = self.observed(&self.points, &seen[i]);
                let known = Known::all(told.iter().flatten());
                let (state, terms) = self.solve(photos[i], None, &observed, known)?;
                told[i] = solver::told(&observed, &terms, &state, None);
                shots.push(Shot::of(&observed, &state, &terms).ok_or_else(nobody)?);
            }
        }
        let others = shots.split_off(1);
        Ok((told, others))
    }

    /// What the points tell, with what is known, and the teeth if there is an image.
    fn solve(
        &self,
        photo: &Photo,
        image: Option<&Image>,
        observed: &Observed,
        known: Option<Known>,
    ) -> Result<(State, Terms)> {
        let seen = observed.seen;
        let longer = f64::from(photo.width.max(photo.height));
        let focal = match photo.focal {
            Some(focal) => (focal.ln(), KNOWN_FOCAL),
            None => ((longer * FOCAL.0 / FILM).ln(), FOCAL.1),
        };
        let inner = &self.points.mean[JAW..POINTS];
        let on_a_line = || Error::Mismatch("the points lie on a line: they are no face's".into());
        let (rotation, scale) = start::orthographic(inner, &seen[JAW..]).ok_or_else(on_a_line)?;
        let terms = Terms {
            coefficients: observed.points.basis.ncols(),
            expressions: self.expressions.as_ref().map_or(0, |e| e.list().len()),
            focal,
            noise: photo.noise,
            jaw: photo.jaw,
            scale,
            against: image.and_then(|image| self.jaw_shut(image, seen)),
            known,
            held: Vec::new(),
        };
        let centre = DVec2::new(f64::from(photo.width), f64::from(photo.height)) / 2.0;
        let middle = |all: &[DVec2]| all.iter().sum::<DVec2>() / all.len() as f64;
        let inner_middle = inner.iter().sum::<DVec3>() / inner.len() as f64;
        let off = (rotation * (inner_middle - self.pivot)).truncate() * scale;
        let pose = camera::Pose {
            rotation,
            place: (middle(&seen[JAW..]) - off - centre) / focal.0.exp(),
            log_depth: focal.0 - scale.ln(),
            log_focal: focal.0,
            pivot: self.pivot,
            centre,
        };
        let state = solver::solve(observed, &terms, pose).ok_or_else(nobody)?;
        let Some(held) = self.looking(photo, observed, &state) else {
            return Ok((state, terms));
        };
        let terms = Terms { held, ..terms };
        let state = solver::solve(observed, &terms, pose).ok_or_else(nobody)?;
        Ok((state, terms))
    }

    /// The weights of the expressions that turn eyes, for where the irises of a photo are; `None` when that is not known.
    fn looking(
        &self,
        photo: &Photo,
        observed: &Observed,
        state: &State,
    ) -> Option<Vec<(usize, f64)>> {
        let irises = photo.irises?.map(DVec2::from_array);
        let expressions = self.expressions.as_ref()?;
        let basis = &observed.points.basis;
        let z = DVector::from_column_slice(&state.unknowns[..basis.ncols()]);
        let mut face = self.model.face();
        let grid = on_grid(&self.model, basis, &z).into_iter();
        let coefficients: Vec<f32> = grid.map(crate::quantise::sigmas).collect();
        face.set_coefficients(&coefficients).ok()?;
        let eyes = gaze::Eyes {
            face: &face,
            expressions,
            camera: &state.pose.camera(),
            seen: observed.seen,
            residuals: &observed.residuals(state)?,
            scale: state.scale(),
        };
        eyes.looking(irises)
    }

    /// What a state tells; `None` when a part of its face is behind the camera.
    fn finish(
        &self,
        observed: &Observed,
        state: State,
        basis: &DMatrix<f64>,
        appearance: Option<Appearance>,
    ) -> Option<Fit> {
        let (z, expression) = state.unknowns.split_at(basis.ncols());
        let z = DVector::from_column_slice(z);
        let grid = on_grid(&self.model, basis, &z);
        let residuals = observed.residuals(&state)?;
        let [rms_px, rms_mm] = inner_rms(&residuals, &state);
        let camera = state.pose.camera();
        let towards = camera.position() - self.pivot;
        let determined = state.determined + state.known;
        Some(Fit {
            code: crate::face::code::of_state(&self.model, &grid),
            coefficients: grid.into_iter().map(crate::quantise::sigmas).collect(),
            expression: expression.to_vec(),
            camera,
            residuals,
            appearance,
            others: Vec::new(),
            quality: Quality {
                rms_px,
                rms_mm,
                unusual: (z.norm_squared() / determined.max(1.0)).sqrt(),
                determined,
                away: towards.angle_between(DVec3::Z),
            },
        })
    }
}

/// The 68 points and then some vertices on the mean head (mm), and how each of them moves by each of
/// the population's independent, standard normal modes (mm, a mode after another): what a fit sees of
/// a model.
///
/// # Errors
/// When the model lacks one of the 68 landmarks.
#[cfg(feature = "fit")]
pub(crate) fn linear(model: &FaceModel, vertices: &[u32]) -> Result<(Vec<DVec3>, Vec<DVec3>)> {
    let mut stencils = shape::ibug(model)?;
    stencils.extend(vertices.iter().map(|&v| vec![(v, 1.0)]));
    let [points, _] = Points::new(model, None, &stencils);
    let modes = (0..points.rates.nrows())
        .flat_map(|k| (0..stencils.len()).map(move |i| (k, i)))
        .map(|(k, i)| DVec3::from_array([0, 1, 2].map(|axis| points.rates[(k, 3 * i + axis)])))
        .map(|rate| rate / shape::SPREAD)
        .collect();
    Ok((points.mean, modes))
}

/// A face's coefficients for independent ones, on its grid.
fn on_grid(model: &FaceModel, basis: &DMatrix<f64>, z: &DVector<f64>) -> Vec<i32> {
    let mut grid = vec![0; model.parts().coefficients()];
    for (point, value) in grid.iter_mut().zip((basis * z).iter()) {
        // Beyond what a face takes lies only what is refused.
        let farthest = f64::from(crate::face::FARTHEST);
        *point = crate::quantise::grid(value.clamp(-farthest, farthest) as f32);
    }
    grid
}

fn nobody() -> Error {
    Error::Mismatch("no face is seen at these points".into())
}

/// The points of a photo, if it can be one.
fn checked(photo: &Photo) -> Result<Vec<DVec2>> {
    let size = DVec2::new(f64::from(photo.width), f64::from(photo.height));
    if !(size.min_element() > 0.0) {
        return Err(Error::Mismatch(format!(
            "a photo of {} x {} pixels is none",
            photo.width, photo.height
        )));
    }
    if photo.points.len() != POINTS {
        return Err(Error::Mismatch(format!(
            "{} points were given, a face has {POINTS}",
            photo.points.len()
        )));
    }
    let positive = |what: &'static str, value: Option<f64>| match value {
        Some(got) if !(got > 0.0 && got.is_finite()) => Err(Error::Value {
            what,
            wanted: "above 0 px".into(),
            got,
        }),
        _ => Ok(()),
    };
    positive("the focal length", photo.focal)?;
    positive("the points' noise", photo.noise)?;
    positive("the jaw's noise", photo.jaw)?;
    if let Some(got) = (photo.irises.iter().flatten().flatten()).find(|x| !x.is_finite()) {
        return Err(Error::Value {
            what: "an iris's coordinate",
            wanted: "a number".into(),
            got: *got,
        });
    }
    let limits = [-OUTSIDE * size, (1.0 + OUTSIDE) * size];
    for point in photo.points {
        for axis in 0..2 {
            let (least, most) = (limits[0][axis], limits[1][axis]);
            if !(least..=most).contains(&point[axis]) {
                return Err(Error::Value {
                    what: "a point's coordinate",
                    wanted: format!("from {least} to {most} px"),
                    got: point[axis],
                });
            }
        }
    }
    Ok(photo.points.iter().map(|&p| DVec2::from_array(p)).collect())
}

/// The median of each channel; 0 of none.
fn median(tones: impl Iterator<Item = DVec3>) -> DVec3 {
    let tones: Vec<DVec3> = tones.collect();
    DVec3::from_array(
        [0, 1, 2].map(|channel| middle(tones.iter().map(|t| t[channel]).collect()).unwrap_or(0.0)),
    )
}

/// The median; `None` of none.
fn middle(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_unstable_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

/// Whether so many positions and normals are a mesh's.
fn check_mesh(positions: usize, normals: usize, vertices: usize) -> Result<()> {
    if positions != vertices || normals != vertices {
        return Err(Error::Mismatch(format!(
            "{positions} positions and {normals} normals are no face of {vertices} vertices"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_that_is_partly_behind_the_camera_is_no_fit() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/www/public/model.phiz");
        let model = FaceModel::parse(&std::fs::read(path).unwrap()).unwrap();
        let fitter = Fitter::new(&model, None).unwrap();
        let points: Vec<[f64; 2]> = fitter.points.mean[..POINTS]
            .iter()
            .map(|p| [320.0 + p.x, 240.0 - p.y])
            .collect();
        let photo = Photo {
            width: 640,
            height: 480,
            points: &points,
            focal: None,
            noise: None,
            jaw: None,
            irises: None,
            others: &[],
            image: None,
        };
        let seen = checked(&photo).unwrap();
        let observed = fitter.observed(&fitter.points, &seen);
        let (mut state, _) = fitter.solve(&photo, None, &observed, None).unwrap();
        let finish = |state: &State| {
            let basis = &fitter.points.basis;
            fitter.finish(&observed, state.clone(), basis, None)
        };
        assert_eq!(finish(&state).expect("is seen").residuals.len(), POINTS);
        // So near that ears are behind.
        state.pose.log_depth = 1.0;
        assert_eq!(finish(&state), None);
    }
}
