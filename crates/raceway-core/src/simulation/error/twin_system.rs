//! Two copies of a scene's equations as one system.

use std::cell::{OnceCell, RefCell};
use std::ops::Range;

use crate::numerics::ode::structure::{Jacobian, Structure};
use crate::numerics::ode::{Choice, IntegrationError, Integrator, OdeSystem, Statistics};
use crate::simulation::model::Model;

/// Two copies of a system as one, so that both take the same steps. Order: the balls of both, then spindle and cage of both.
///
/// Each copy has its own Jacobian. The copies are always close to each other. A contact that has closed in only one of them can still make their
/// Jacobians entirely different.
pub struct Pair<'a> {
    model: &'a Model,
    /// Entries of the balls of one copy.
    balls: usize,
    apart: RefCell<[Vec<f64>; 2]>,
}

impl<'a> Pair<'a> {
    pub fn new(model: &'a Model) -> Self {
        let Structure { blocks, block, .. } = model.structure();
        let copy = || vec![0.0; model.dimension()];
        Self { model, balls: blocks * block, apart: RefCell::new([copy(), copy()]) }
    }

    /// The ranges of a copy's entries in the joint vector: balls, spindle and cage.
    fn ranges(&self, copy: usize) -> [Range<usize>; 2] {
        let (balls, border) = (self.balls, self.model.dimension() - self.balls);
        let border_from = 2 * balls + copy * border;
        [copy * balls..(copy + 1) * balls, border_from..border_from + border]
    }

    /// One copy's entries out of the joint vector.
    pub fn take(&self, copy: usize, joint: &[f64], own: &mut [f64]) {
        let (of_balls, of_border) = own.split_at_mut(self.balls);
        let [balls, border] = self.ranges(copy);
        of_balls.copy_from_slice(&joint[balls]);
        of_border.copy_from_slice(&joint[border]);
    }

    /// One copy's entries into the joint vector.
    fn put(&self, copy: usize, own: &[f64], joint: &mut [f64]) {
        let [balls, border] = self.ranges(copy);
        joint[balls].copy_from_slice(&own[..self.balls]);
        joint[border].copy_from_slice(&own[self.balls..]);
    }

    pub fn joined(&self, one: &[f64], other: &[f64]) -> Vec<f64> {
        let mut joint = vec![0.0; 2 * self.model.dimension()];
        self.put(0, one, &mut joint);
        self.put(1, other, &mut joint);
        joint
    }
}

impl OdeSystem for Pair<'_> {
    fn dimension(&self) -> usize {
        2 * self.model.dimension()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        let [own, rate] = &mut *self.apart.borrow_mut();
        for copy in 0..2 {
            self.take(copy, state, own);
            self.model.derivative(time, own, rate);
            self.put(copy, rate, derivative);
        }
    }

    fn structure(&self) -> Structure {
        let mut structure = self.model.structure();
        let border = structure.border;
        let of_the_other: Vec<_> =
            structure.border_pairs.iter().map(|(position, velocity)| (position + border, velocity + border)).collect();
        structure.border_pairs.extend(of_the_other);
        Structure { blocks: 2 * structure.blocks, border: 2 * border, ..structure }
    }

    /// Fixed steps are the same for both copies without further control.
    fn own_method<'s>(&'s self, time: f64, state: &[f64], step: f64) -> Option<Box<dyn Integrator + 's>> {
        let start = |copy: usize| {
            let mut own = vec![0.0; self.model.dimension()];
            self.take(copy, state, &mut own);
            self.model.own_method(time, &own, step)
        };
        let joint = OnceCell::new();
        Some(Box::new(Twins { pair: self, copies: [start(0)?, start(1)?], joint }))
    }

    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        let structure = self.model.structure();
        let (blocks, block, border) = (structure.blocks, structure.block, structure.border);
        let mut one = Jacobian::new(&structure);
        let [mut own, mut own_rate, mut own_displacement] = [(); 3].map(|()| vec![0.0; self.model.dimension()]);
        let mut evaluations = 0;
        for copy in 0..2 {
            self.take(copy, state, &mut own);
            self.take(copy, rate, &mut own_rate);
            self.take(copy, displacement, &mut own_displacement);
            evaluations += self.model.jacobian(time, &own, &own_rate, &own_displacement, &mut one);
            let columns = copy * border..(copy + 1) * border;
            for index in 0..blocks {
                let joint = copy * blocks + index;
                for (i, entry) in one.blocks.of(index).enumerate() {
                    *jacobian.blocks.entry_mut(joint, i / block, i % block) = entry;
                }
                for (i, entry) in one.right.of(index).enumerate() {
                    *jacobian.right.entry_mut(joint, i / border, columns.start + i % border) = entry;
                }
                for (i, entry) in one.below.of(index).enumerate() {
                    *jacobian.below.entry_mut(joint, columns.start + i / block, i % block) = entry;
                }
            }
            for row in 0..border {
                let from = (columns.start + row) * 2 * border + columns.start;
                jacobian.corner_mut()[from..from + border]
                    .copy_from_slice(&one.corner()[row * border..(row + 1) * border]);
            }
        }
        evaluations / 2
    }
}

/// Both copies, each with its own integrator that takes the same steps as the other.
struct Twins<'a> {
    pair: &'a Pair<'a>,
    copies: [Box<dyn Integrator + 'a>; 2],
    joint: OnceCell<Vec<f64>>,
}

impl Integrator for Twins<'_> {
    fn step(&mut self, limit: f64) -> Result<(), IntegrationError> {
        self.joint.take();
        self.copies.iter_mut().try_for_each(|copy| copy.step(limit))
    }

    fn time(&self) -> f64 {
        self.copies[0].time()
    }

    fn previous_time(&self) -> f64 {
        self.copies[0].previous_time()
    }

    fn state(&self) -> &[f64] {
        self.joint.get_or_init(|| self.pair.joined(self.copies[0].state(), self.copies[1].state()))
    }

    fn interpolate(&self, time: f64, state: &mut [f64]) {
        let mut own = vec![0.0; self.pair.model.dimension()];
        for (index, copy) in self.copies.iter().enumerate() {
            copy.interpolate(time, &mut own);
            self.pair.put(index, &own, state);
        }
    }

    fn restart(&mut self) {
        self.copies.iter_mut().for_each(|copy| copy.restart());
    }

    fn statistics(&self) -> Statistics {
        self.copies[0].statistics()
    }

    fn choice(&self) -> Choice {
        self.copies[0].choice()
    }
}
