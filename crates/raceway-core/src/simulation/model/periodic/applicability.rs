//! Scenes and outputs whose motion can repeat with every ball.

use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::Outputs;
use crate::simulation::model::spindle_only;
use crate::simulation::model::terms::ActiveTerms;

/// Why there is no steady orbit of one ball passage; `None`: there may be one.
pub fn inapplicability(scene: &Scene, needs: &ActiveTerms, outputs: &Outputs) -> Option<String> {
    let reason = if !scene.operation.speed.is_constant() {
        "the speed changes"
    } else if scene.operating_speed() == 0.0 {
        "nothing turns"
    } else if needs.unbalance {
        "unbalance turns with the spindle and not with the balls"
    } else {
        return spindle_only::inapplicability(scene, needs, outputs);
    };
    Some(reason.into())
}
