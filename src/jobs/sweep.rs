//! Recovery of lost runs, removal of expired jobs, and a test write after the disk was full.

use std::sync::Arc;

use super::error::JobError;
use super::parts::Parts;
use super::store::deliveries;
use super::store::pool::Lock;
use super::store::{maintenance, studies};

/// Sweeps and removes expired jobs regularly until the service stops or is dropped.
pub fn start(parts: &Arc<Parts>) {
    start_expiry(parts);
    let (parts, every) = (Arc::downgrade(parts), parts.settings.sweep_every);
    tokio::spawn(async move {
        loop {
            tokio::time::sleep(every).await;
            let Some(parts) = parts.upgrade() else { return };
            if parts.is_stopping() {
                return;
            }
            let swept = sweep(&parts).await;
            parts.store.note_sweep(swept.is_ok());
            if let Err(error) = swept {
                tracing::warn!(%error, "a sweep failed");
                if error.lacks_tables() {
                    recreate_tables(&parts).await;
                }
            }
        }
    });
}

/// Apart from the sweeps: after a pause there may be many jobs to remove, and lost runs must not wait for them.
fn start_expiry(parts: &Arc<Parts>) {
    let (parts, every) = (Arc::downgrade(parts), parts.settings.sweep_every);
    tokio::spawn(async move {
        loop {
            let Some(strong) = parts.upgrade().filter(|parts| !parts.is_stopping()) else { return };
            if let Err(error) = expire(&strong).await {
                tracing::warn!(%error, "expired jobs could not be removed");
            }
            drop(strong);
            tokio::time::sleep(every).await;
        }
    });
}

/// Removes all expired jobs, a transaction for some at a time.
pub async fn expire(parts: &Parts) -> Result<(), JobError> {
    parts.check_file_in_place()?;
    let remembered = parts.settings.remember_expired.try_into().unwrap_or(jiff::SignedDuration::MAX);
    while !parts.is_stopping() && parts.store.expire(remembered).await? {}
    while !parts.is_stopping() && parts.store.forget().await? {}
    parts.store.expire_series(remembered).await?;
    let lost = parts.store.remove_lost_recordings().await?;
    if lost > 0 {
        tracing::info!(results = lost, "time series of lost runs were removed");
    }
    Ok(())
}

/// Creates the tables as at a start, after the database was created anew and its jobs are gone.
async fn recreate_tables(parts: &Parts) {
    match parts.store.migrate().await {
        Ok(()) => tracing::warn!("the database was created anew; its tables exist again"),
        Err(error) => tracing::error!(%error, "the database was created anew; its tables cannot be created"),
    }
}

/// One sweep.
pub async fn sweep(parts: &Parts) -> Result<(), JobError> {
    parts.check_file_in_place()?;
    if parts.store.disk_is_full() {
        parts.store.note(parts.store.try_write().await)?;
    }
    parts.store.join_counts().await?;
    let delivered = redeliver(parts).await?;
    if delivered > 0 {
        tracing::info!(jobs = delivered, "lost jobs are back in the queue");
    }
    Ok(())
}

async fn redeliver(parts: &Parts) -> Result<usize, JobError> {
    let mut tx = parts.store.begin_locked(Lock::Sweep).await?;
    let lost_after = parts.settings.lost_after.try_into().unwrap_or(jiff::SignedDuration::MAX);
    let (keep_s, max_lost_runs) = (parts.settings.keep_s, parts.settings.max_lost_runs);
    maintenance::end_cancelled(&mut tx, lost_after, keep_s).await?;
    let lost = maintenance::undeliverable(&mut tx, lost_after, &parts.running.ids()).await?;
    maintenance::list_worker(&mut tx, parts.worker_id, parts.settings.workers, lost_after).await?;
    studies::remove_lost_shards(&mut tx, lost_after, max_lost_runs).await?;
    let hastened = deliveries::hasten(&mut tx).await?;
    if hastened > 0 {
        tracing::warn!(jobs = hastened, "a clock was set back; deliveries that waited for a later time are due now");
    }
    let recalled = parts.queue.recall(&mut tx, parts.settings.lost_after).await?;
    if recalled > 0 {
        tracing::warn!(jobs = recalled, "deliveries that were lost with a broken connection are delivered again");
    }
    let slots = maintenance::slots(&mut tx).await?;
    let missing = studies::missing_shards(&mut tx, slots, keep_s).await?;
    let numbers = parts.queue.enqueue(&mut tx, lost.len()).await?;
    for (lost, number) in lost.iter().zip(numbers) {
        maintenance::redeliver(&mut tx, *lost, number, max_lost_runs).await?;
    }
    for (study, count) in &missing {
        let numbers = parts.queue.enqueue(&mut tx, *count).await?;
        studies::add_shards(&mut tx, *study, &numbers).await?;
    }
    tx.commit().await?;
    parts.queue.wake();
    Ok(lost.len() + missing.len())
}
