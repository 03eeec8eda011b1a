//! One growth cycle, from top to bottom.
//!
//! Internodes stand in the order of their creation, so a parent always comes before its children:
//! a pass in that order goes from the root up, a pass in reverse from the tips down.

use std::f32::consts::{FRAC_PI_2, TAU};

use deeptree_graph::{Draws, Purpose, Quat, Seed, Vec3};

use crate::density::DensityGrid;
use crate::internode::{Bud, Internode, SLOTS};
use crate::parameters::Parameters;
use crate::surroundings::Surroundings;
use crate::tropism;

/// No lateral bud flushes where the density is above this.
const DENSITY_CAP: f32 = 100.0;

/// A tree while it grows.
pub(crate) struct Growth<'a> {
    p: &'a Parameters,
    seed: Seed,
    pub(crate) internodes: Vec<Internode>,
    density: DensityGrid,
    crown_centre: Vec3,
    longest_path: f32,
    remap: Vec<Option<u32>>,
    tips_above: Vec<u32>,
}

impl<'a> Growth<'a> {
    /// One internode of length 0, upright, with a random yaw.
    ///
    /// The yaw is ours: with a fixed one, all trees of a species with a large apical angle lean
    /// the same way.
    pub(crate) fn new(p: &'a Parameters, seed: Seed) -> Self {
        let yaw =
            seed.draws(deeptree_graph::Lineage::ROOT, Purpose::RootYaw).uniform() as f32 * TAU;
        let frame = (Quat::from_rotation_y(yaw) * Quat::from_rotation_x(FRAC_PI_2)).normalize();
        Self {
            p,
            seed,
            internodes: vec![Internode::root(frame, p.tip_radius)],
            density: DensityGrid::new(p.density_radius),
            crown_centre: Vec3::ZERO,
            longest_path: 0.0,
            remap: Vec::new(),
            tips_above: Vec::new(),
        }
    }

    /// Runs one cycle. `others` are the bases of the internodes of other trees near by.
    pub(crate) fn cycle(&mut self, number: u32, surroundings: &impl Surroundings, others: &[Vec3]) {
        let bases = self.internodes.iter().map(|i| i.base);
        self.density.fill(bases.chain(others.iter().copied()));
        self.measure_from_the_root();
        self.measure_from_the_tips();
        self.prune(number);
        self.balance();
        self.grow(number, surroundings);
        self.place();
        self.remove(|_, internode| !surroundings.admits(internode.base, internode.tip()));
        self.thicken();
    }

    /// Removes what the last cycle grew into the ground, as the next one would.
    pub(crate) fn finish(&mut self) {
        self.remove(|_, internode| internode.base.y < 0.0);
        self.thicken();
    }

    /// Removes these internodes, of which there is at least one, with all they bear.
    pub(crate) fn prune_these(&mut self, gone: &[u32]) {
        self.remove(|i, _| gone.contains(&(i as u32)));
        self.thicken();
    }

    /// ρ of each internode, the crown's centre, and the longest path.
    fn measure_from_the_root(&mut self) {
        let mut sum = Vec3::ZERO;
        self.longest_path = 0.0;
        for i in 0..self.internodes.len() {
            if let Some(parent) = self.internodes[i].parent {
                let parent = &self.internodes[parent as usize];
                self.internodes[i].root_path = parent.root_path + parent.length;
            }
            let internode = &self.internodes[i];
            sum += internode.base;
            self.longest_path = self.longest_path.max(internode.root_path + internode.length);
        }
        self.crown_centre = sum / self.internodes.len() as f32;
    }

    /// T and M of each internode, and which child has the largest subtree.
    fn measure_from_the_tips(&mut self) {
        for internode in &mut self.internodes {
            (internode.length_above, internode.biomass) = (0.0, 0.0);
        }
        for i in (0..self.internodes.len()).rev() {
            let children = self.internodes[i].children;
            let mut largest = (None, f32::NEG_INFINITY);
            for child in children.into_iter().flatten() {
                let c = &mut self.internodes[child as usize];
                c.is_largest = false;
                let length = c.length_above + c.length;
                let biomass = c.biomass + c.length * c.thickness;
                if length > largest.1 {
                    largest = (Some(child), length);
                }
                self.internodes[i].length_above += length;
                self.internodes[i].biomass += biomass;
            }
            if let Some(child) = largest.0 {
                self.internodes[child as usize].is_largest = true;
            }
        }
    }

    /// Low branches, branches below the ground, and tips that are shed.
    fn prune(&mut self, number: u32) {
        let (p, seed, longest) = (self.p, self.seed, self.longest_path);
        self.remove(|_, internode| {
            let is_low =
                internode.order >= 1 && internode.root_path < p.low_branch_pruning_factor * longest;
            let is_shed = || {
                internode.is_end() && f32::from(internode.order) > p.shedding_protection && {
                    let chance = p.shedding_base + p.shedding_slope * internode.age as f32;
                    let mut draws = seed.draws(internode.lineage, Purpose::Shedding);
                    draws = draws.at(u64::from(number));
                    draws.uniform() < f64::from(chance.min(p.shedding_cap))
                }
            };
            is_low || internode.base.y < 0.0 || is_shed()
        });
    }

    /// Removes internodes with all they bear. What has lost its tip never elongates again.
    fn remove(&mut self, gone: impl Fn(usize, &Internode) -> bool) {
        self.remap.clear();
        let mut kept = 0;
        for (i, internode) in self.internodes.iter().enumerate() {
            let parent_gone = internode.parent.is_some_and(|p| self.remap[p as usize].is_none());
            let keep = i == 0 || !(parent_gone || gone(i, internode));
            self.remap.push(keep.then_some(kept));
            kept += u32::from(keep);
        }
        if kept as usize == self.internodes.len() {
            return;
        }
        let remap = &self.remap;
        let mut i = 0;
        self.internodes.retain_mut(|internode| {
            let keep = remap[i].is_some();
            i += 1;
            internode.parent = internode.parent.and_then(|p| remap[p as usize]);
            internode.children = internode.children.map(|c| c.and_then(|c| remap[c as usize]));
            keep
        });
    }

    /// Auxin and sag from the tips down, then levels from the root up.
    fn balance(&mut self) {
        let p = self.p;
        for i in (0..self.internodes.len()).rev() {
            let mut auxin = 0.0;
            let parent = &self.internodes[i];
            for child in parent.children.into_iter().flatten() {
                let child = &self.internodes[child as usize];
                auxin += if child.is_end() {
                    p.apical_dominance_base
                        * libm::powf(p.apical_dominance_distance_factor, child.age as f32)
                } else {
                    child.auxin * parent.auxin_passed
                };
            }
            let parent = &mut self.internodes[i];
            parent.auxin = auxin;
            parent.sag = if parent.is_end() {
                0.0
            } else {
                let stiffness =
                    libm::powf(parent.thickness / p.tip_radius, p.gravity_bending_angle_factor);
                (p.gravity_bending_strength * parent.biomass / stiffness).min(p.sag_cap)
            };
        }
        for i in 1..self.internodes.len() {
            if let Some(parent) = self.internodes[i].parent {
                let level = self.internodes[parent as usize].level;
                let internode = &mut self.internodes[i];
                internode.level = level + u32::from(!internode.is_largest);
            }
        }
    }

    /// Lets every internode that was there at the start of the cycle act.
    fn grow(&mut self, number: u32, surroundings: &impl Surroundings) {
        for i in 0..self.internodes.len() {
            let internode = &mut self.internodes[i];
            internode.age += 1;
            match internode.buds[0] {
                Bud::Dormant => self.elongate(i, number, surroundings),
                Bud::Flushed => self.flush_laterals(i, number, surroundings),
                Bud::Dead => {}
            }
        }
    }

    /// The draws of one internode in one cycle.
    fn draws(&self, i: usize, purpose: Purpose, number: u32) -> Draws {
        self.seed.draws(self.internodes[i].lineage, purpose).at(u64::from(number))
    }

    /// The direction from the crown's centre to the internode.
    fn outward(&self, i: usize) -> Option<Vec3> {
        (self.internodes[i].base - self.crown_centre).try_normalize()
    }

    /// An apical bud dies, rests, or lengthens its shoot; at full length it flushes.
    fn elongate(&mut self, i: usize, number: u32, surroundings: &impl Surroundings) {
        let p = self.p;
        let dies = self.internodes[i].order >= 1
            && self.draws(i, Purpose::ApicalKill, number).uniform()
                < f64::from(p.apical_kill_probability);
        if dies {
            self.internodes[i].buds[0] = Bud::Dead;
            return;
        }
        let light = surroundings.light(self.internodes[i].tip(), self.outward(i));
        let activity = libm::powf(light.availability, p.apical_lighting_factor);
        if activity < 1.0
            && self.draws(i, Purpose::ApicalRest, number).uniform() >= f64::from(activity)
        {
            return;
        }
        let vigour = libm::powf(p.apical_control_base, -(self.internodes[i].level as f32));
        let target = p.internode_length
            + p.internode_length_deviation
                * self.draws(i, Purpose::InternodeLength, number).normal() as f32;
        let internode = &mut self.internodes[i];
        internode.length += p.growth_scale * p.growth_rate * p.internode_length * vigour;
        if internode.length <= target {
            return;
        }
        internode.length = target.max(0.0);
        internode.auxin_passed = libm::powf(p.apical_dominance_age_factor, internode.length);
        internode.buds[0] = Bud::Flushed;
        self.flush_apical(i, light.direction);
    }

    /// Creates the apical child: roll, apical angle, gravitropism, phototropism.
    fn flush_apical(&mut self, i: usize, light: Option<Vec3>) {
        let p = self.p;
        let internode = &mut self.internodes[i];
        let mut angles = self.seed.draws(internode.lineage, Purpose::BranchingAngles);
        for angle in &mut internode.branching_angles {
            *angle = degrees(&mut angles, p.branching_angle_mean, p.branching_angle_variance);
        }
        let mut angles = self.seed.draws(internode.lineage, Purpose::ApicalAngles);
        let roll = degrees(&mut angles, p.roll_angle_mean, p.roll_angle_variance);
        let apical = degrees(&mut angles, p.apical_angle_mean, p.apical_angle_variance);
        // The front is −z, so a roll about it is a rotation about z by the negative angle.
        let mut frame =
            internode.frame * Quat::from_rotation_z(-roll) * Quat::from_rotation_y(apical);
        frame = tropism::turn(frame, Vec3::NEG_Y, p.gravitropism);
        if let Some(light) = light {
            frame = tropism::turn(frame, light, p.phototropism);
        }
        self.add_child(i, 0, frame.normalize());
    }

    /// Lets the dormant lateral buds die or flush.
    ///
    /// A bud flushes with `P = max(0, 1 − A) · I^F_LLF / (κ D)`, never where D is above its cap. So
    /// with u uniform it flushes exactly when D lies below `max(0, 1 − A) · I^F_LLF / (κ u)`. Where
    /// there are obstacles, the exponent has a least value.
    fn flush_laterals(&mut self, i: usize, number: u32, surroundings: &impl Surroundings) {
        let p = self.p;
        let buds = p.lateral_buds as usize;
        let mut limits = [0.0f32; SLOTS - 1];
        let strength = (1.0 - self.internodes[i].auxin).max(0.0);
        for (k, limit) in limits.iter_mut().enumerate().take(buds) {
            if self.internodes[i].buds[k + 1] != Bud::Dormant {
                continue;
            }
            let kill = self.draws(i, Purpose::LateralKill, number).at(k as u64).uniform();
            if kill < f64::from(p.lateral_kill_probability) {
                self.internodes[i].buds[k + 1] = Bud::Dead;
                continue;
            }
            let tip = self.internodes[i].tip();
            let light = surroundings.light(tip, self.outward(i)).availability;
            let exponent = p.lateral_lighting_factor.max(surroundings.least_lighting_factor());
            let activity = libm::powf(light, exponent);
            let u = self.draws(i, Purpose::LateralFlush, number).at(k as u64).open_uniform() as f32;
            *limit = (strength * activity / (p.crown_density * u)).min(DENSITY_CAP);
        }
        let most = limits[0].max(limits[1]);
        if most <= 0.0 {
            return;
        }
        let density = self.density.at(self.internodes[i].base, most);
        for (k, limit) in limits.into_iter().enumerate() {
            if density < limit {
                self.flush_lateral(i, k);
            }
        }
    }

    /// Creates the child of lateral bud `k`: β off the front, the buds spread evenly around it.
    ///
    /// It gets neither roll, apical angle nor tropism.
    fn flush_lateral(&mut self, i: usize, k: usize) {
        let internode = &mut self.internodes[i];
        internode.buds[k + 1] = Bud::Flushed;
        let around = k as f32 * TAU / self.p.lateral_buds;
        let frame = internode.frame
            * Quat::from_rotation_z(-around)
            * Quat::from_rotation_x(internode.branching_angles[k]);
        self.add_child(i, k + 1, frame.normalize());
    }

    fn add_child(&mut self, parent: usize, slot: usize, frame: Quat) {
        let child = Internode::child(
            &self.internodes[parent],
            parent as u32,
            slot as u8,
            frame,
            self.p.tip_radius,
        );
        self.internodes[parent].children[slot] = Some(self.internodes.len() as u32);
        self.internodes.push(child);
    }

    /// Frames and positions from the root to the tips: the frame of birth, sagging by now.
    fn place(&mut self) {
        for i in 0..self.internodes.len() {
            let internode = &self.internodes[i];
            let (mut frame, base) = match internode.parent {
                Some(parent) => {
                    let parent = &self.internodes[parent as usize];
                    ((parent.frame * internode.desired).normalize(), parent.tip())
                }
                None => (internode.desired, Vec3::ZERO),
            };
            if internode.sag > 0.0 {
                let slope = (frame * Vec3::NEG_Z).y.abs();
                frame = tropism::turn(frame, Vec3::NEG_Y, internode.sag * (1.0 - slope));
            }
            let internode = &mut self.internodes[i];
            (internode.frame, internode.base) = (frame, base);
        }
    }

    /// The pipe model: `θ = θ_end · N^(1/n)` with N the tips above, which is `θ^n = Σ θ_child^n`.
    fn thicken(&mut self) {
        let n = self.internodes.len();
        self.tips_above.clear();
        self.tips_above.resize(n, 0);
        for i in (0..n).rev() {
            let internode = &mut self.internodes[i];
            let tips = self.tips_above[i].max(1);
            internode.thickness = self.p.tip_radius
                * if self.p.pipe_exponent == 2.0 {
                    libm::sqrtf(tips as f32)
                } else {
                    libm::powf(tips as f32, 1.0 / self.p.pipe_exponent)
                };
            if let Some(parent) = internode.parent {
                self.tips_above[parent as usize] += tips;
            }
        }
    }
}

/// A normal angle in radians, from a mean in degrees and the root of a deviation in degrees.
///
/// The published "variances" act as `sd = V²`: only so do the spreads of the published angles
/// come out.
fn degrees(draws: &mut Draws, mean: f32, variance: f32) -> f32 {
    (mean + variance * variance * draws.normal() as f32).to_radians()
}
