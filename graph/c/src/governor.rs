//! Tiers that are chosen by the times of frames.

use std::ffi::{CString, c_char};

use afterimage::host::{Governor, TierLimits};

use crate::error::Fault;
use crate::{AfterimagePipeline, array, null, text, with};

/// Limits that `afterimage_govern` holds.
#[repr(C)]
pub struct AfterimageLimits {
    /// The budget in milliseconds.
    pub ms: f64,
    /// The least claim in JOD of a tier that may be chosen, 10 for no visible difference; 0 for no such limit. If no
    /// tier reaches it, the best claim is the only choice, and the budget is not held.
    pub min_jod: f64,
    /// The display whose claims count, as `measure --display` names it; null for any.
    pub display: *const c_char,
}

/// Holds limits from the next frame on: chooses one of these tiers, which are in order from the worst picture to the
/// best, by the times that `afterimage_report_frame_time` gets. Null `limits` keep the present tier from now on, as
/// `afterimage_set_tier` does.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`, `limits` is null or limits, and `tiers` is null or has `tier_count`
/// elements, which are null or texts with a zero at their ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_govern(
    pipeline: *mut AfterimagePipeline,
    limits: *const AfterimageLimits,
    tiers: *const *const c_char,
    tier_count: usize,
) -> bool {
    let govern = |pipeline: &mut AfterimagePipeline| {
        // SAFETY: what the caller promises.
        let Some(limits) = (unsafe { limits.as_ref() }) else {
            pipeline.look.stop_governing();
            return Ok(());
        };
        // SAFETY: the same.
        let tiers = unsafe { array(tiers, tier_count, "tiers") }?;
        // SAFETY: the same.
        let tiers = tiers.iter().map(|tier| unsafe { text(*tier, "tiers") }).collect::<Result<Vec<_>, _>>()?;
        let mut wanted = TierLimits::new(limits.ms);
        if limits.min_jod != 0.0 {
            wanted = wanted.min_jod(limits.min_jod);
        }
        if !limits.display.is_null() {
            // SAFETY: the same.
            wanted = wanted.display(unsafe { text(limits.display, "display") }?);
        }
        Ok(pipeline.look.govern(wanted, &tiers)?)
    };
    // SAFETY: the same.
    unsafe { with(pipeline, govern) }
}

/// Reports the milliseconds of the last frame, and the seconds since the frame before, to `afterimage_govern`. The next
/// frame has the tier that it then chooses.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_report_frame_time(pipeline: *mut AfterimagePipeline, ms: f64, dt: f64) -> bool {
    // SAFETY: what the caller promises.
    unsafe { with(pipeline, |pipeline| Ok(pipeline.look.report_frame_time(ms, dt).map(drop)?)) }
}

/// The name of the present tier; null for the pipeline without one. It is valid until the next call of this function
/// for the pipeline, or until that is freed.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`, `tier` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_tier(pipeline: *mut AfterimagePipeline, tier: *mut *const c_char) -> bool {
    let read = |pipeline: &mut AfterimagePipeline| {
        // SAFETY: what the caller promises.
        let tier = unsafe { tier.as_mut() }.ok_or_else(|| null("tier"))?;
        *tier = kept(&mut pipeline.tier, pipeline.look.tier().map(str::to_owned))?;
        Ok(())
    };
    // SAFETY: the same.
    unsafe { with(pipeline, read) }
}

/// The reason why the limits of `afterimage_govern` are not held at present; null if they are. It is valid until the
/// next call of this function for the pipeline, or until that is freed.
///
/// # Safety
/// `pipeline` is null or of `afterimage_open`, `shortfall` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn afterimage_shortfall(
    pipeline: *mut AfterimagePipeline,
    shortfall: *mut *const c_char,
) -> bool {
    let read = |pipeline: &mut AfterimagePipeline| {
        // SAFETY: what the caller promises.
        let shortfall = unsafe { shortfall.as_mut() }.ok_or_else(|| null("shortfall"))?;
        let found = pipeline.look.governor().and_then(Governor::shortfall);
        *shortfall = kept(&mut pipeline.shortfall, found.map(|found| found.to_string()))?;
        Ok(())
    };
    // SAFETY: the same.
    unsafe { with(pipeline, read) }
}

/// Keeps a text for C; null for none.
fn kept(place: &mut Option<CString>, text: Option<String>) -> Result<*const c_char, Fault> {
    *place = text.map(CString::new).transpose()?;
    Ok(place.as_ref().map_or(std::ptr::null(), |text| text.as_ptr()))
}
