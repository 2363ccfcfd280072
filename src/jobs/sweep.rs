//! Brings back what was lost, removes what has expired, and tries the disk again after it was full.

use std::sync::Arc;

use super::JobError;
use super::queue::Delivery;
use super::service::Inner;
use super::store::database::Lock;
use super::store::{studies, upkeep};

/// Sweeps now and then until the service is dropped.
pub fn start(inner: &Arc<Inner>) {
    let (inner, every) = (Arc::downgrade(inner), inner.settings.sweep_every);
    tokio::spawn(async move {
        loop {
            tokio::time::sleep(every).await;
            let Some(inner) = inner.upgrade() else { return };
            if inner.is_stopping() {
                return;
            }
            let swept = sweep(&inner).await;
            inner.store.note_sweep(swept.is_ok());
            if let Err(error) = swept {
                tracing::warn!(%error, "a sweep was broken off");
                if error.lacks_tables() {
                    bring_tables_back(&inner).await;
                }
            }
        }
    });
}

/// What a start does: someone has made the database anew, and its jobs are gone.
async fn bring_tables_back(inner: &Inner) {
    match inner.store.migrate().await {
        Ok(()) => tracing::warn!("the database was made anew, and has its tables again"),
        Err(error) => tracing::error!(%error, "the database was made anew, and its tables cannot be made"),
    }
}

/// One sweep.
pub async fn sweep(inner: &Inner) -> Result<(), JobError> {
    inner.check_place()?;
    if inner.store.disk_is_full() {
        inner.store.note(inner.store.try_write().await)?;
    }
    let delivered = redeliver(inner).await?;
    if delivered > 0 {
        tracing::info!(jobs = delivered, "stranded jobs are back in the queue");
    }
    let expired = inner.store.expired().await?;
    if !expired.is_empty() {
        inner.store.remove(&expired).await?;
    }
    inner.store.forget_keys().await?;
    Ok(())
}

async fn redeliver(inner: &Inner) -> Result<usize, JobError> {
    let mut tx = inner.store.begin_alone(Lock::Sweep).await?;
    let lost_after = inner.settings.lost_after.try_into().unwrap_or(jiff::SignedDuration::MAX);
    let (keep_s, max_lost_runs) = (inner.settings.keep_s, inner.settings.max_lost_runs);
    upkeep::end_cancelled(&mut tx, lost_after, keep_s).await?;
    let stranded = upkeep::stranded(&mut tx, lost_after, &inner.running.ids()).await?;
    upkeep::work(&mut tx, inner.worker, inner.settings.workers, lost_after).await?;
    studies::lose_strands(&mut tx, lost_after, max_lost_runs).await?;
    let hastened = inner.queue.hasten(&mut tx).await?;
    if hastened > 0 {
        tracing::warn!(jobs = hastened, "a clock was set back; what waited for the time before is due now");
    }
    let recalled = inner.queue.recall(&mut tx, inner.settings.lost_after).await?;
    if recalled > 0 {
        tracing::warn!(jobs = recalled, "what was handed out on a link that broke is delivered again");
    }
    let slots = upkeep::slots(&mut tx).await?;
    let lacking = studies::lacking(&mut tx, slots, keep_s).await?;
    let deliveries = inner.queue.enqueue(&mut tx, &stranded).await?;
    for (stranded, delivery) in stranded.iter().zip(deliveries) {
        upkeep::redeliver(&mut tx, stranded.job, delivery, max_lost_runs).await?;
    }
    for (study, count) in &lacking {
        let strands = Delivery::strands(*study, *count);
        let deliveries = inner.queue.enqueue(&mut tx, &strands).await?;
        studies::add_strands(&mut tx, *study, &deliveries).await?;
    }
    tx.commit().await?;
    inner.queue.wake();
    Ok(stranded.len() + lacking.len())
}
