//! The trade of each wire's format, in words.

use super::digits::significant;
use super::report::{MeasureReport, Row};
use super::variants::VariantKind;

/// The error in codes of a pipeline, and the bytes that its passes move.
#[derive(Clone, Copy)]
pub(crate) struct Traded {
    pub(crate) codes: f64,
    pub(crate) bytes: u64,
}

/// A change of format, `node.format=FORMAT`, as a sentence; `None` for another change.
pub(crate) fn sentence(change: &str, before: Traded, after: Traded) -> Option<String> {
    let (node, format) = change.split_once(".format=")?;
    let (codes, share) = (after.codes - before.codes, 100.0 * (1.0 - after.bytes as f64 / before.bytes as f64));
    let costs = if codes < 0.0 { "gains" } else { "costs" };
    let saves = if share < 0.0 { "adds" } else { "saves" };
    let (codes, share) = (significant(codes.abs()), significant(share.abs()));
    Some(format!("`{node}` in {format} {costs} {codes} codes and {saves} {share} % of the bytes moved"))
}

/// A sentence for each format of a wire that was measured.
pub(super) fn wires(report: &MeasureReport) -> Vec<String> {
    let traded = |row: &Row| {
        let worst = row.worst();
        Traded { codes: worst.errors.p999, bytes: worst.cost.bytes_moved }
    };
    let Some(written) = report.rows.iter().find(|row| row.kind == VariantKind::Written).map(traded) else {
        return Vec::new();
    };
    report.rows.iter().filter_map(|row| sentence(&row.variant, written, traded(row))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_a_trade_of_codes_for_bytes() {
        let [wide, narrow] = [(0.5, 1000), (0.6, 880)].map(|(codes, bytes)| Traded { codes, bytes });
        let text = |change, before, after| sentence(change, before, after);
        let packed = "`mips` in Rg11b10Ufloat costs 0.1000 codes and saves 12.00 % of the bytes moved";
        assert_eq!(text("mips.format=Rg11b10Ufloat", wide, narrow).as_deref(), Some(packed));
        let wider = "`mips` in Rgba16Float gains 0.1000 codes and adds 13.64 % of the bytes moved";
        assert_eq!(text("mips.format=Rgba16Float", narrow, wide).as_deref(), Some(wider));
        assert_eq!(text("mips.filter=Tap9", wide, narrow), None);
    }
}
