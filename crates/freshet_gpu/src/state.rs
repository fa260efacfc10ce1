//! Reading and writing the whole state, waiting for the GPU.

use freshet_core::field::{Field, FieldData};
use freshet_core::snapshot::{BodyPose, Exchange, Snapshot, check_room};
use freshet_core::solver::SolverError;
use freshet_core::step::{BodyInput, Impulse, StepInput};

use glam::Quat;

use crate::buffers::Buffers;
use crate::layout::{
    AccelerationRecord, Binding, BodyInputRecord, BodyRecord, ExchangeRecord, ParticleRecord, StepControl,
};
use crate::passes::{history_words, past_words};
use crate::solver::{GpuSolver, Start, halves};

impl GpuSolver {
    /// Makes the ticks that were prepared and waits for those in flight; the next `collect` gives their reports.
    pub(crate) fn finish_ticks(&mut self) -> Result<(), SolverError> {
        if !self.prepared.is_empty() {
            self.submit(|solver, encoder| solver.encode(encoder))?;
        }
        for (about, bytes) in self.readback.finish(&self.device)? {
            let report = self.account(&about, &bytes)?;
            self.late.push(report);
        }
        Ok(())
    }

    fn download<T: bytemuck::AnyBitPattern>(&mut self, binding: Binding, count: usize) -> Result<Vec<T>, SolverError> {
        let Some(buffer) = self.buffers.get(binding) else { return Ok(Vec::new()) };
        let bytes = (count * size_of::<T>()) as u64;
        let data = self.readback.download(&self.device, &self.queue, buffer, bytes)?;
        Ok(data.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    fn control(&mut self) -> Result<StepControl, SolverError> {
        let control = self.download(Binding::Control, 1)?.pop();
        control.ok_or_else(|| SolverError::Device("the control buffer is gone".to_owned()))
    }

    /// The bodies as the last tick left them; waits for it.
    ///
    /// # Errors
    /// If the device failed.
    pub fn body_states(&mut self) -> Result<Vec<BodyRecord>, SolverError> {
        self.finish_ticks()?;
        self.download(Binding::Bodies, self.plan.bodies.len())
    }

    pub(crate) fn read_field(&mut self, field: Field) -> Result<FieldData, SolverError> {
        if !self.plan.fields.contains(&field) {
            return Err(SolverError::NoSuchField(field.name()));
        }
        self.finish_ticks()?;
        let count = self.control()?.count as usize;
        let particles = |solver: &mut Self| solver.download::<ParticleRecord>(Binding::Particles, count);
        let densities = |solver: &mut Self| solver.download::<[f32; 2]>(Binding::Densities, count);
        Ok(match field {
            Field::Id => FieldData::Integer(particles(self)?.iter().map(|particle| particle.id).collect()),
            Field::Position => FieldData::Vector(particles(self)?.iter().map(|particle| particle.position).collect()),
            Field::Velocity => FieldData::Vector(particles(self)?.iter().map(|particle| particle.velocity).collect()),
            Field::Speed => {
                FieldData::Scalar(particles(self)?.iter().map(|particle| particle.velocity.length()).collect())
            }
            Field::RemainingLife => {
                FieldData::Scalar(particles(self)?.iter().map(|particle| particle.remaining_life).collect())
            }
            Field::Density => FieldData::Scalar(densities(self)?.iter().map(|[density, _]| *density).collect()),
            Field::Pressure => {
                FieldData::Scalar(densities(self)?.iter().map(|[density, term]| term * density * density).collect())
            }
            Field::Acceleration => {
                let records = self.download::<AccelerationRecord>(Binding::Accelerations, count)?;
                FieldData::Vector(records.iter().map(|record| record.acceleration).collect())
            }
        })
    }

    pub(crate) fn take_snapshot(&mut self) -> Result<Snapshot, SolverError> {
        self.finish_ticks()?;
        let control = self.control()?;
        let count = control.count as usize;
        let mut particles: Vec<ParticleRecord> = self.download(Binding::Particles, count)?;
        // None where pressures are not solved for.
        let mut pressures: Vec<f32> = self.download(Binding::Solves, count)?;
        let (words, past) = (history_words(&self.plan) as usize, past_words(&self.plan) as usize);
        let kept: Vec<f32> = self.download(Binding::Histories, words * count)?;
        let (mut histories, mut excesses) = (Vec::new(), Vec::new());
        if !(pressures.is_empty() && kept.is_empty()) {
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_unstable_by_key(|&index| particles[index].id);
            pressures = order.iter().filter_map(|&index| pressures.get(index).copied()).collect();
            for &index in &order {
                let (of_past, carried) = kept[words * index..words * (index + 1)].split_at(past);
                histories.extend_from_slice(of_past);
                excesses.extend_from_slice(carried);
            }
        }
        particles.sort_unstable_by_key(|particle| particle.id);
        let bodies = self.download::<BodyRecord>(Binding::Bodies, self.plan.bodies.len())?;
        Ok(Snapshot {
            tick: self.ticks,
            time: self.time,
            carry: control.remaining.min(StepInput::MAX_DURATION),
            emitted: self.emitted,
            next_id: control.next_id,
            gravity: self.gravity,
            ids: particles.iter().map(|particle| particle.id).collect(),
            positions: particles.iter().map(|particle| particle.position).collect(),
            velocities: particles.iter().map(|particle| particle.velocity).collect(),
            remaining_lives: particles.iter().map(|particle| particle.remaining_life).collect(),
            pressures,
            excesses,
            last_substep: control.last_substep,
            integrator: self.plan.parameters.integrator,
            histories,
            exchanges: bodies.iter().map(|body| body.exchanges.map(Exchange::from)).collect(),
            poses: bodies.iter().map(pose_of).collect(),
        })
    }

    pub(crate) fn load_snapshot(&mut self, snapshot: &Snapshot) -> Result<(), SolverError> {
        snapshot.validate()?;
        check_room(snapshot.ids.len(), self.plan.max_particles)?;
        let count = snapshot.ids.len() as u32;
        // Ticks that were not encoded will not be.
        self.prepared.clear();
        self.finish_ticks()?;
        self.late.clear();
        self.spawning.clear();
        if count > self.buffers.capacity {
            let capacity = count.next_power_of_two().min(self.plan.max_particles);
            self.buffers = Buffers::new(&self.device, &self.queue, &self.plan, capacity, &self.options, &self.memory)?;
            self.rebind()?;
        }
        self.gravity = snapshot.gravity;
        self.time = snapshot.time;
        self.emitted = snapshot.emitted;
        self.ticks = snapshot.tick;
        self.falling = 0;
        self.start =
            snapshot.is_start().then(|| Start { ids: snapshot.ids.clone(), positions: snapshot.positions.clone() });
        let particles: Vec<ParticleRecord> = (0..snapshot.ids.len())
            .map(|index| ParticleRecord {
                position: snapshot.positions[index],
                id: snapshot.ids[index],
                velocity: snapshot.velocities[index],
                remaining_life: snapshot.remaining_lives[index],
            })
            .collect();
        // A tick that covered nothing of what it was asked to.
        let (asked, remaining) = (snapshot.carry, snapshot.carry);
        let last_substep = snapshot.substep_for(&self.plan.parameters);
        let control = StepControl { next_id: snapshot.next_id, asked, remaining, last_substep, ..Default::default() };
        self.upload_state(&particles, control);
        // Snapshots of other plans have none.
        let mut pressures = snapshot.pressures.clone();
        pressures.resize(particles.len(), 0.0);
        self.buffers.write(&self.queue, Binding::Solves, &pressures);
        let pasts = snapshot.histories_for(self.plan.parameters.integrator);
        self.upload_kept(particles.len(), pasts, &snapshot.excesses);
        self.known.carry = snapshot.carry;
        self.upload_bodies(snapshot)
    }

    /// Writes what is kept of so many particles: of each its past, then the density that it carries; zeros for what is not known.
    pub(crate) fn upload_kept(&self, count: usize, pasts: &[f32], excesses: &[f32]) {
        let (words, past) = (history_words(&self.plan) as usize, past_words(&self.plan) as usize);
        let mut kept = vec![0.0; words * count];
        for (index, of_one) in kept.chunks_exact_mut(words.max(1)).enumerate() {
            let (of_past, carried) = of_one.split_at_mut(past);
            if let Some(known) = pasts.get(past * index..past * (index + 1)) {
                of_past.copy_from_slice(known);
            }
            for (value, known) in carried.iter_mut().zip(excesses.get(index)) {
                *value = *known;
            }
        }
        self.buffers.write(&self.queue, Binding::Histories, &kept);
    }

    /// Writes what the bodies' engines have not heard of, and where the bodies were left.
    fn upload_bodies(&mut self, snapshot: &Snapshot) -> Result<(), SolverError> {
        let mut bodies = self.download::<BodyRecord>(Binding::Bodies, self.plan.bodies.len())?;
        for (index, body) in bodies.iter_mut().enumerate() {
            let known = snapshot.exchanges.get(index).copied().unwrap_or_default();
            body.exchanges = known.map(ExchangeRecord::from);
            let left = snapshot.poses.get(index).copied().flatten();
            body.is_placed = u32::from(left.is_some());
            if let Some(BodyPose { position, rotation, swollen }) = left {
                body.swollen = swollen;
                body.position = position;
                body.rotation = rotation.to_array();
            }
        }
        self.buffers.write(&self.queue, Binding::Bodies, &bodies);
        Ok(())
    }
}

fn pose_of(body: &BodyRecord) -> Option<BodyPose> {
    let pose = BodyPose { position: body.position, rotation: Quat::from_array(body.rotation), swollen: body.swollen };
    (body.is_placed != 0).then_some(pose)
}

impl From<ExchangeRecord> for Exchange {
    fn from(record: ExchangeRecord) -> Self {
        let [low, high] = record.tick_plus_one;
        Self {
            tick_plus_one: u64::from(low) | u64::from(high) << 32,
            error: Impulse { linear: record.linear, angular: record.angular },
        }
    }
}

impl From<Exchange> for ExchangeRecord {
    fn from(exchange: Exchange) -> Self {
        Self {
            linear: exchange.error.linear,
            angular: exchange.error.angular,
            tick_plus_one: halves(exchange.tick_plus_one),
            ..Default::default()
        }
    }
}

impl From<&BodyInput> for BodyInputRecord {
    fn from(body: &BodyInput) -> Self {
        Self {
            position: body.position,
            inverse_mass: body.inverse_mass,
            rotation: body.rotation.to_array(),
            linear_velocity: body.linear_velocity,
            is_free: u32::from(body.free),
            angular_velocity: body.angular_velocity,
            is_put: u32::from(body.placed),
            inertia_x: body.inverse_inertia.x_axis,
            inertia_y: body.inverse_inertia.y_axis,
            inertia_z: body.inverse_inertia.z_axis,
            acceleration: body.acceleration,
            forecast_linear: body.forecast.linear,
            forecast_angular: body.forecast.angular,
            corrected_before: halves(body.corrected_before),
            ..Default::default()
        }
    }
}
