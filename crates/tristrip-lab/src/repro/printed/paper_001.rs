//! Paper 001: recomputes every printed number that follows from other printed numbers.

use super::super::paper::{Claim, Paper, PrintedSavings, PublishedRow, PublishedTable, Statistic};
use super::super::papers::load;

fn paper() -> Paper {
    load(&["001".to_owned()].into()).unwrap().remove(0)
}

impl Paper {
    fn table(&self, name: &str) -> &PublishedTable {
        self.tables.iter().find(|table| table.name == name).expect(name)
    }

    fn savings(&self, table: &str, of: &str, than: &str) -> Vec<f64> {
        PrintedSavings { table: table.into(), of: of.into(), than: than.into() }.all(self)
    }

    fn has_remark(&self, numbers: &str) -> bool {
        self.remarks.iter().any(|remark| remark.contains(numbers))
    }
}

/// Returns the minimum, the maximum and the mean of some numbers, with one decimal. Models with two
/// stand-ins count once.
fn range(mut numbers: Vec<f64>) -> [String; 3] {
    numbers.dedup();
    let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
    let [least, greatest] = [f64::min, f64::max].map(|pick| numbers.iter().copied().reduce(pick).unwrap());
    [least, greatest, mean].map(|x| format!("{x:.1}"))
}

#[test]
fn shares_are_those_of_the_printed_traffic() {
    let paper = paper();
    let traffic = paper.table("table 2, traffic");
    for name in ["table 2, as shares", "table 2, as shares, ours"] {
        let shares = paper.table(name);
        assert_eq!(shares.rows.len(), traffic.rows.len());
        for (row, of) in shares.rows.iter().zip(&traffic.rows) {
            let [single, sent @ ..] = &of.published[..] else { unreachable!() };
            for (share, sent) in row.published.iter().zip(sent) {
                assert_eq!(format!("{share:.1}"), format!("{:.1}", 100.0 * sent / single), "{}", row.model);
            }
        }
    }
    let updates = ["table 2, updates", "table 2, updates, ours"].map(|name| paper.table(name));
    for (row, ours) in updates[0].rows.iter().zip(&updates[1].rows) {
        assert_eq!(row.published, ours.published);
    }
}

/// A collapse drops about equally many triangles at every level. On average, a level has the mean
/// number of triangles of both ends.
#[test]
fn traffic_and_strips_follow_from_the_triangles() {
    let paper = paper();
    let traffic = paper.table("table 2, traffic");
    for (row, sizes) in traffic.rows.iter().zip(&paper.table("table 1").rows) {
        let [_, base, collapses] = sizes.published[..] else { unreachable!() };
        let mean = f64::midpoint(sizes.triangles as f64, base);
        let single = 112.0 * 3.0 * mean * (collapses + 1.0) / (1_u64 << 30) as f64;
        let printed = row.published[0];
        assert!((single - printed).abs() < f64::max(0.05, 0.005 * printed), "{} {single}", row.model);
    }
    let strips = paper.table("table 2, unfiltered strips");
    for row in &strips.rows {
        let of = |table: &PublishedTable| table.rows.iter().position(|r| r.model == row.model).unwrap();
        let sent = &traffic.rows[of(traffic)].published;
        let base = paper.table("table 1").rows[of(paper.table("table 1"))].published[1];
        let triangles = row.triangles as f64;
        let implied = sent[1] / sent[0] * 3.0 * (triangles + base) / (2.0 * triangles);
        assert!(row.published.iter().all(|&x| format!("{x:.2}") == format!("{implied:.2}")), "{implied}");
    }
    assert_eq!(strips.rows.len(), 2);
}

#[test]
fn claims_and_remarks_state_what_follows_from_the_cells() {
    let paper = paper();
    let claim = |at: &str, figure: &str| {
        let with_figure = |claim: &&Claim| match &claim.statistic {
            Statistic::Levels { figure: of, .. } | Statistic::LevelsOf { figure: of, .. } => of == figure,
            _ => false,
        };
        let claim = paper.claims.iter().filter(|claim| claim.at == at).find(with_figure).expect(figure);
        (format!("{:.1}", claim.number(&paper)), claim.number_to(&paper).map(|x| format!("{x:.1}")))
    };
    // 1. Traffic.
    let [least, greatest, _] = range(paper.savings("table 2, traffic", "DTFS", "PM"));
    assert_eq!(claim("abstract", "saving_triangles_dtfs"), (least, Some(greatest)));
    let [least, greatest, _] = range(paper.savings("table 2, traffic", "DTFS", "STSS"));
    assert!(
        paper.has_remark(&format!("{least} to {greatest} % in the cells of table 2")),
        "{least} {greatest}"
    );
    assert_eq!(claim("table 2", "saving_dtfs"), (least, Some(greatest)));
    assert_eq!(claim("section 5", "percent_base_dtfs").0, "102.0");
    let bunny = paper.table("table 1").rows.iter().find(|row| row.model == "Bunny").unwrap();
    assert_eq!(format!("{}", 3.0 * bunny.published[1]), "10413");
    let unused = bunny.vertices.unwrap() as f64 - bunny.published[0] - bunny.published[2];
    assert_eq!(format!("{unused}"), "1114");
    assert!(paper.table("table 1").shows.contains("1,114"));
    // 2. Refinement: the printed savings are those of 14 + 2 u bytes.
    let bytes = |fixed: f64| {
        let of_row = |row: &PublishedRow| {
            100.0 * (1.0 - (fixed + 2.0 * row.published[1]) / (fixed + 2.0 * row.published[0]))
        };
        range(paper.table("table 2, updates").rows.iter().map(of_row).collect())
    };
    let [least, greatest, mean] = bytes(14.0);
    assert_eq!(claim("abstract", "saving_bytes_with_id"), (least, Some(greatest)));
    assert_eq!(claim("section 5", "saving_bytes_with_id").0, mean);
    let [least, greatest, mean] = bytes(12.0);
    assert!(paper.has_remark(&format!("{least} to {greatest} % and {mean} %")), "{least} {greatest} {mean}");
    let [least, greatest, _] = range(paper.savings("table 2, updates", "u encoded", "u naive"));
    assert_eq!(claim("table 2", "saving_updates"), (least, Some(greatest)));
}

#[test]
fn bytes_of_transmissions_follow_from_the_printed_cells() {
    let paper = paper();
    let (sizes, updates) = (paper.table("table 1"), paper.table("table 2, updates"));
    let bytes = paper.table("equation 2, bytes");
    assert_eq!(bytes.rows.len(), sizes.rows.len());
    for ((row, sizes), updates) in bytes.rows.iter().zip(&sizes.rows).zip(&updates.rows) {
        assert!([&sizes.file, &updates.file].iter().all(|file| **file == row.file));
        let ([vertices, _, collapses], [naive, encoded]) = (&sizes.published[..], &updates.published[..])
        else {
            unreachable!()
        };
        let records = |slots: f64| collapses * (12.0 + 2.0 * slots);
        let expected = [12.0 * vertices, records(*naive), records(*encoded)];
        assert_eq!(row.published, expected.map(f64::round), "{}", row.model);
    }
    // The maps have at least as many vertices as NF sends at each level.
    let traffic = paper.table("table 2, traffic");
    let sent = |model: &str| {
        let row = |table: &PublishedTable| table.rows.iter().position(|row| row.model == model).unwrap();
        let (traffic, size) = (&traffic.rows[row(traffic)].published, &sizes.rows[row(sizes)]);
        let vertices =
            traffic[1] / traffic[0] * 3.0 * f64::midpoint(size.triangles as f64, size.published[1]);
        let digits = format!("{vertices:.0}");
        let (thousands, rest) = digits.split_at(digits.len() - 3);
        format!("{thousands},{rest}")
    };
    assert!(paper.has_remark(&format!("{} and {} vertices", sent("Bunny"), sent("Dragon"))));
}
