//! The prescribed colours of the generic head.

use super::FitResult;
use super::base_mesh::BaseMesh;
use super::eyeball::Eyeball;
use super::template::Template;

/// Paints the template.
pub fn paint(template: &mut Template, _eye: &Eyeball, _base: &BaseMesh) -> FitResult<()> {
    template.colours = vec![[222, 180, 155]; template.positions.len()];
    Ok(())
}
