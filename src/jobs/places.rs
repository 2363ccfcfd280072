//! Limits of unfinished work: single jobs and points of studies, of all owners and of one.

use std::collections::HashMap;

use super::error::JobError;
use super::store::submissions::Unfinished;

/// Largest amounts of unfinished work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorkLimits {
    /// Queued and running single jobs.
    pub jobs: u64,
    /// Those of one owner; `None`: half of all where there are tokens.
    pub jobs_of_owner: Option<u64>,
    /// Unfinished points of studies.
    pub points: u64,
    /// Those of one owner; `None`: half of all where there are tokens.
    pub points_of_owner: Option<u64>,
}

impl Default for WorkLimits {
    fn default() -> Self {
        Self { jobs: 10_000, jobs_of_owner: None, points: 100_000, points_of_owner: None }
    }
}

/// Rest of one limit after a submission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Left {
    /// Largest number of this owner.
    pub limit: u64,
    /// Further ones that would be accepted now.
    pub left: u64,
}

/// Free places in the queue.
#[derive(Debug)]
pub struct Places {
    limits: WorkLimits,
    has_tokens: bool,
    unfinished: HashMap<String, Unfinished>,
}

impl Places {
    /// Places beside `unfinished` work, by owner.
    pub fn new(limits: WorkLimits, has_tokens: bool, unfinished: HashMap<String, Unfinished>) -> Self {
        Self { limits, has_tokens, unfinished }
    }

    /// Takes the places of a single job, or of the points of a study.
    pub fn take(&mut self, owner: &str, points: Option<usize>) -> Result<(), JobError> {
        let places = points.map_or(1, |points| points as u64);
        let (all, of_owner) = self.limits_of(points.is_some());
        let used_by_all: u64 = self.unfinished.values().map(|work| work.of(points.is_some())).sum();
        if let Some(points) = points.filter(|_| places > of_owner) {
            return Err(JobError::StudyTooLarge { points, limit: of_owner });
        }
        let work = self.unfinished.entry(owner.to_owned()).or_default();
        let used = work.of(points.is_some());
        for (used, limit, of_owner) in [(used_by_all, all, false), (used, of_owner, true)] {
            if used.saturating_add(places) > limit {
                return Err(match points {
                    None => JobError::QueueFull { limit, of_owner },
                    Some(points) => JobError::PointsFull { points, unfinished: used, limit, of_owner },
                });
            }
        }
        *(if points.is_some() { &mut work.points } else { &mut work.jobs }) += places;
        Ok(())
    }

    /// Gives back the places of a single job, or of the points of a study.
    pub fn give_back(&mut self, owner: &str, points: Option<usize>) {
        let Some(work) = self.unfinished.get_mut(owner) else { return };
        match points {
            Some(points) => work.points = work.points.saturating_sub(points as u64),
            None => work.jobs = work.jobs.saturating_sub(1),
        }
    }

    /// Rest of the limit of an owner, of single jobs or of points.
    pub fn left(&self, owner: &str, points: bool) -> Left {
        let (all, limit) = self.limits_of(points);
        let used_by_all: u64 = self.unfinished.values().map(|work| work.of(points)).sum();
        let used = self.unfinished.get(owner).map_or(0, |work| work.of(points));
        Left { limit, left: limit.saturating_sub(used).min(all.saturating_sub(used_by_all)) }
    }

    /// The limits of all owners and of one, of single jobs or of points.
    fn limits_of(&self, points: bool) -> (u64, u64) {
        let limits = &self.limits;
        let (all, of_owner) =
            if points { (limits.points, limits.points_of_owner) } else { (limits.jobs, limits.jobs_of_owner) };
        // Rounded up, so that a limit of one remains one.
        let default = if self.has_tokens { all.div_ceil(2) } else { all };
        (all, of_owner.unwrap_or(default).min(all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(has_tokens: bool) -> Places {
        let limits = WorkLimits { jobs: 5, points: 100, ..WorkLimits::default() };
        Places::new(limits, has_tokens, HashMap::from([("b".to_owned(), Unfinished { jobs: 3, points: 60 })]))
    }

    #[test]
    fn an_owner_has_half_where_there_are_tokens_and_all_otherwise() {
        let mut shared = places(true);
        assert_eq!(shared.left("a", false), Left { limit: 3, left: 2 });
        assert!(matches!(shared.take("b", None), Err(JobError::QueueFull { limit: 3, of_owner: true })));
        assert!(shared.take("a", None).is_ok() && shared.take("a", None).is_ok());
        assert!(matches!(shared.take("a", None), Err(JobError::QueueFull { limit: 5, of_owner: false })));
        assert_eq!(shared.left("a", false), Left { limit: 3, left: 0 });
        let mut open = places(false);
        assert!(open.take("b", None).is_ok() && open.take("b", None).is_ok() && open.take("b", None).is_err());
    }

    #[test]
    fn points_are_counted_apart_from_jobs() {
        let mut places = places(true);
        assert_eq!(places.left("a", true), Left { limit: 50, left: 40 });
        assert!(matches!(
            places.take("a", Some(41)),
            Err(JobError::PointsFull { points: 41, unfinished: 60, limit: 100, of_owner: false })
        ));
        // No wait would make it fit.
        assert!(matches!(places.take("a", Some(51)), Err(JobError::StudyTooLarge { points: 51, limit: 50 })));
        assert!(places.take("a", Some(40)).is_ok());
        assert_eq!(places.left("a", true), Left { limit: 50, left: 0 });
        assert_eq!(places.left("a", false).left, 2);
    }
}
