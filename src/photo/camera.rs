//! The camera of a photo.

use glam::{DMat3, DVec2, DVec3};

use crate::{Error, Result};

/// A pinhole camera without distortion, square pixels, principal point in the middle of the image.
///
/// The camera's frame is the usual one of computer vision (Hartley & Zisserman 2004, section 6.1):
/// x to the right, y down, z forward; pixels are counted from the upper left corner of the image, x
/// to the right and y down, and a pixel's centre is at a half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// From the head's frame to the camera's: a rotation.
    pub rotation: DMat3,
    /// Where the head's origin is in the camera's frame, mm.
    pub translation: DVec3,
    /// The focal length, px.
    pub focal: f64,
    /// The principal point, px.
    pub centre: DVec2,
}

/// How far the axes of a rotation may be from unit length and right angles: it may come from a text with four digits.
const SQUARE: f64 = 1e-3;

impl Camera {
    /// Refuses numbers that no camera has.
    pub(super) fn check(&self) -> Result<()> {
        let off = self.rotation.transpose() * self.rotation - DMat3::IDENTITY;
        let is_rotation = off.to_cols_array().iter().all(|x| x.abs() < SQUARE)
            && self.rotation.determinant() > 0.0;
        let is_somewhere = self.translation.is_finite() && self.centre.is_finite();
        match self.focal > 0.0 && self.focal.is_finite() && is_rotation && is_somewhere {
            true => Ok(()),
            false => Err(Error::Mismatch(
                "a camera has a focal length above 0, a rotation, and only finite numbers".into(),
            )),
        }
    }

    /// A point of the head (mm) in the camera's frame, mm.
    pub fn to_camera(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }

    /// Where a point of the head (mm) is in the image, px; not a number when it is not in front of
    /// the camera.
    pub fn project(&self, p: DVec3) -> DVec2 {
        let q = self.to_camera(p);
        match q.z > 0.0 {
            true => self.centre + q.truncate() * (self.focal / q.z),
            false => DVec2::NAN,
        }
    }

    /// The middle of the camera in the head's frame, mm.
    pub fn position(&self) -> DVec3 {
        self.rotation.transpose() * -self.translation
    }

    /// The head's yaw, pitch and roll, radians: it is turned by roll about z (out of the face),
    /// then pitch about x, then yaw about y. All are zero when it looks straight into the camera;
    /// positive yaw turns it to its left, pitch down, roll towards its right shoulder.
    pub fn angles(&self) -> [f64; 3] {
        // What remains when the frames' half turn about x is taken off.
        let turn = HALF_TURN * self.rotation;
        let (yaw, pitch, roll) = glam::DQuat::from_mat3(&turn).to_euler(glam::EulerRot::YXZ);
        [yaw, pitch, roll]
    }

    /// The rotation of a head with these [`Camera::angles`].
    pub fn turned([yaw, pitch, roll]: [f64; 3]) -> DMat3 {
        HALF_TURN * DMat3::from_euler(glam::EulerRot::YXZ, yaw, pitch, roll)
    }
}

/// From y up and z towards the viewer to y down and z forward.
const HALF_TURN: DMat3 = DMat3::from_cols(
    DVec3::new(1.0, 0.0, 0.0),
    DVec3::new(0.0, -1.0, 0.0),
    DVec3::new(0.0, 0.0, -1.0),
);

/// What the solver moves: a camera by numbers that have no constraints.
///
/// A point p of the head is at R (p - pivot) + Z (a, b, 1): the pivot's place in the image and its
/// depth are told apart, so that the depth trades with the focal length alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub rotation: DMat3,
    /// Tangents of the angles at which the pivot is seen, right and down.
    pub place: DVec2,
    /// The logarithm of the pivot's depth in mm.
    pub log_depth: f64,
    /// The logarithm of the focal length in px.
    pub log_focal: f64,
    pub pivot: DVec3,
    pub centre: DVec2,
}

/// How many numbers [`Pose::moved`] takes: a rotation vector, the two of the place, the
/// logarithms of depth and focal length.
pub(super) const POSE: usize = 7;

/// A point in the image, and how it moves there.
pub(super) struct Seen {
    /// px.
    pub at: DVec2,
    /// By the pose, px a unit.
    pub by_pose: [DVec2; POSE],
    /// By the point's own motion in the head's frame, px a mm, along each axis.
    pub by_point: [DVec2; 3],
}

impl Pose {
    pub fn camera(&self) -> Camera {
        let depth = self.log_depth.exp();
        Camera {
            rotation: self.rotation,
            translation: self.place.extend(1.0) * depth - self.rotation * self.pivot,
            focal: self.log_focal.exp(),
            centre: self.centre,
        }
    }

    /// The pose after a step.
    pub fn moved(&self, step: &[f64]) -> Self {
        let turn = DVec3::new(step[0], step[1], step[2]);
        Self {
            rotation: DMat3::from_quat(glam::DQuat::from_scaled_axis(turn)) * self.rotation,
            place: self.place + DVec2::new(step[3], step[4]),
            log_depth: self.log_depth + step[5],
            log_focal: self.log_focal + step[6],
            ..*self
        }
    }

    /// Where a point of the head is seen; `None` when it is not in front of the camera.
    pub fn see(&self, p: DVec3) -> Option<Seen> {
        let depth = self.log_depth.exp();
        let focal = self.log_focal.exp();
        let arm = self.rotation * (p - self.pivot);
        let q = arm + self.place.extend(1.0) * depth;
        // A tenth of the way to the head's middle is nearer than any nose reaches.
        if !(q.z > 0.1 * depth) {
            return None;
        }
        let from_centre = q.truncate() * (focal / q.z);
        // How the image of q moves with q.
        let image = |d: DVec3| (d.truncate() * focal - from_centre * d.z) / q.z;
        let turned = |axis: DVec3| image(axis.cross(arm));
        Some(Seen {
            at: self.centre + from_centre,
            by_pose: [
                turned(DVec3::X),
                turned(DVec3::Y),
                turned(DVec3::Z),
                image(DVec3::X * depth),
                image(DVec3::Y * depth),
                image(self.place.extend(1.0) * depth),
                from_centre,
            ],
            by_point: [
                image(self.rotation.x_axis),
                image(self.rotation.y_axis),
                image(self.rotation.z_axis),
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivatives_are_those_of_the_projection() {
        let pose = Pose {
            rotation: Camera::turned([0.5, -0.2, 0.1]),
            place: DVec2::new(0.05, -0.1),
            log_depth: 6.0,
            log_focal: 6.5,
            pivot: DVec3::new(3.0, -20.0, 40.0),
            centre: DVec2::new(320.0, 240.0),
        };
        let p = DVec3::new(30.0, 12.0, 60.0);
        let seen = pose.see(p).expect("is in front");
        assert!(seen.at.distance(pose.camera().project(p)) < 1e-9);
        let h = 1e-5;
        for i in 0..POSE {
            let mut step = [0.0; POSE];
            step[i] = h;
            let ahead = pose.moved(&step).see(p).expect("is in front").at;
            step[i] = -h;
            let behind = pose.moved(&step).see(p).expect("is in front").at;
            let slope = (ahead - behind) / (2.0 * h);
            // Central differences are off by the square of h.
            assert!(slope.distance(seen.by_pose[i]) < 1e-5, "{i}");
        }
        for axis in 0..3 {
            let step = DVec3::AXES[axis] * h;
            let ahead = pose.see(p + step).expect("is in front").at;
            let behind = pose.see(p - step).expect("is in front").at;
            let slope = (ahead - behind) / (2.0 * h);
            assert!(slope.distance(seen.by_point[axis]) < 1e-5, "{axis}");
        }
    }

    #[test]
    fn angles_are_what_they_say() {
        let frontal = Camera {
            rotation: Camera::turned([0.0; 3]),
            translation: DVec3::new(0.0, 0.0, 1000.0),
            focal: 1000.0,
            centre: DVec2::new(500.0, 400.0),
        };
        // The subject's left is on the right of the image, what is above is above.
        let seen = frontal.project(DVec3::new(10.0, 20.0, 0.0));
        assert!(seen.distance(DVec2::new(510.0, 380.0)) < 1e-9);
        assert!(frontal.position().distance(DVec3::new(0.0, 0.0, 1000.0)) < 1e-9);
        let nose = DVec3::new(0.0, 0.0, 100.0);
        let look = |angles| Camera {
            rotation: Camera::turned(angles),
            ..frontal
        };
        assert!(look([0.3, 0.0, 0.0]).project(nose).x > 510.0);
        assert!(look([0.0, 0.3, 0.0]).project(nose).y > 410.0);
        // Its right is the image's left: the crown goes there.
        let crown = DVec3::new(0.0, 100.0, 0.0);
        assert!(look([0.0, 0.0, 0.3]).project(crown).x < 490.0);
        let angles = [0.4, -0.2, 0.15];
        let back = look(angles).angles();
        assert!(angles.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
