//! Pictures of the tables, and of what tables are made of.

use crate::descriptors::{D2_BINS, D2_REACH};
use crate::plot::{Axis, Chart, Figure, Mark, Series};
use crate::table::Table;

/// Bars of shares that are not named right, so that they begin at zero and yet can be told apart.
pub fn recognition(table: &Table) -> Figure {
    let groups: Vec<String> = table.column("models").iter().map(|name| name.replace(", ", "\n")).collect();
    let ways = ["rules alone", "Gsh+s with SVM alone", "rules, then SVM", "ours, by fitted surfaces"];
    let wrong = |way: &&str| table.numbers(way).iter().map(|right| 100.0 - right).collect::<Vec<_>>();
    let series: Vec<(&str, Vec<f64>)> = ways.iter().map(|way| (*way, wrong(way))).collect();
    let chart = Chart::bars(
        "Models named wrong",
        &groups,
        Axis::linear("models named wrong, %", [0.0, 18.0]),
        &series,
    );
    Figure::of_charts(1, [760.0, 340.0], vec![chart])
}

/// Bars by descriptor, complete beside partial, and how each type fares.
pub fn descriptors(table: &Table) -> Figure {
    let names = table.column("descriptor");
    let half = names.len() / 2;
    let groups: Vec<String> = names[..half]
        .iter()
        .map(|name| name.replace(", by", "\nby").replace(", ", ",\n").replace(" surfaces", "\nsurfaces"))
        .collect();
    let y = || Axis::linear("named right, %", [0.0, 105.0]);
    let all = table.numbers("all");
    let halves = [("complete models", all[..half].to_vec()), ("partial models", all[half..].to_vec())];
    let mut charts = vec![Chart::bars("all types", &groups, y(), &halves)];
    for kind in ["plane", "cylinder", "cone", "sphere", "torus"] {
        let values = table.numbers(kind);
        let halves =
            [("complete models", values[..half].to_vec()), ("partial models", values[half..].to_vec())];
        charts.push(Chart::bars(kind, &groups, y(), &halves));
    }
    Figure::of_charts(2, [570.0, 270.0], charts)
}

/// Shares named right by the number of edges, a panel per kind of model.
pub fn decimation(table: &Table) -> Figure {
    let charts = by_models(table).into_iter().map(|(name, rows)| Chart {
        title: name,
        x: Axis::log("edges along the root of the area", [7.0, 74.0], &[8.0, 16.0, 32.0, 64.0]),
        y: Axis::linear("named right, %", [50.0, 101.5]),
        series: ways(table, "edges", &rows),
        notes: Vec::new(),
    });
    Figure::of_charts(4, [260.0, 230.0], charts.collect())
}

/// Shares named right by the half-angle and by the arc.
pub fn half_angle(table: &Table) -> Figure {
    let mut charts: Vec<Chart> = Vec::new();
    for (name, rows) in by_models(table) {
        // A cylinder is one row, said in the text.
        if rows.len() < 2 {
            continue;
        }
        let is_arc = name.ends_with("arc");
        let x = if is_arc {
            Axis::log("arc, degrees", [18.0, 360.0], &[20.0, 45.0, 90.0, 180.0, 330.0])
        } else {
            Axis::log("half-angle, degrees", [1.9, 32.0], &[2.0, 3.0, 5.0, 10.0, 20.0, 30.0])
        };
        charts.push(Chart {
            title: name.split(':').next().unwrap_or_default().to_owned(),
            x,
            y: Axis::linear("named right, %", [0.0, 103.0]),
            series: ways(table, "degrees", &rows),
            notes: Vec::new(),
        });
    }
    Figure::of_charts(3, [320.0, 270.0], charts)
}

/// Models in the order of the table with their rows.
fn by_models(table: &Table) -> Vec<(String, Vec<usize>)> {
    let mut found: Vec<(String, Vec<usize>)> = Vec::new();
    for (row, name) in table.column("models").iter().enumerate() {
        match found.last_mut().filter(|last| last.0 == *name) {
            Some((_, rows)) => rows.push(row),
            None => found.push(((*name).to_owned(), vec![row])),
        }
    }
    found
}

/// A line for each way to name a type, over a column of the table.
fn ways(table: &Table, x: &str, rows: &[usize]) -> Vec<Series> {
    let ways = ["rules alone", "Gsh+s with SVM alone", "rules, then SVM", "ours, by fitted surfaces"];
    lines(table, x, rows, &ways)
}

fn lines(table: &Table, x: &str, rows: &[usize], columns: &[&str]) -> Vec<Series> {
    let at = table.numbers(x);
    let line = |(color, name): (usize, &&str)| {
        let values = table.numbers(name);
        let points = rows.iter().map(|row| [at[*row], values[*row]]).collect();
        Series { name: (*name).to_owned(), color, mark: Mark::DottedLine, points }
    };
    columns.iter().enumerate().map(line).collect()
}

/// Spread of sizes over the bound, over noise: on the bound is one.
pub fn bound(table: &Table) -> Figure {
    const LARGEST: f64 = 40.0;
    let methods: Vec<&str> = table.headings().iter().skip(2).map(String::as_str).collect();
    let charts = by_models(table).into_iter().map(|(name, rows)| Chart {
        title: name,
        x: Axis::linear("noise, edge lengths", [0.0, 0.85]),
        y: Axis::log("spread over the bound", [0.9, LARGEST], &[1.0, 2.0, 5.0, 10.0, 20.0]),
        series: lines(table, "noise", &rows, &methods)
            .into_iter()
            .map(|series| Series {
                points: series.points.into_iter().filter(|p| p[1] <= LARGEST).collect(),
                ..series
            })
            .collect(),
        notes: Vec::new(),
    });
    Figure::of_charts(5, [250.0, 230.0], charts.collect())
}

/// Bars of the hard tier by type.
pub fn hard(table: &Table) -> Figure {
    const N: usize = 6;
    let groups: Vec<String> = table.column("models")[..N].iter().map(|name| (*name).to_owned()).collect();
    let ways = ["rules, then SVM", "ours", "ours, where certain", "wrong ones called ambiguous"];
    let series: Vec<(&str, Vec<f64>)> =
        ways.iter().map(|way| (*way, table.numbers(way)[..N].to_vec())).collect();
    let chart = Chart::bars("The hard tier", &groups, Axis::linear("models, %", [0.0, 105.0]), &series);
    Figure::of_charts(1, [760.0, 320.0], vec![chart])
}

/// Errors of sizes over noise.
pub fn sizes(table: &Table) -> Figure {
    let methods: Vec<&str> = table.headings().iter().skip(2).map(String::as_str).collect();
    let charts = by_models(table).into_iter().map(|(name, rows)| Chart {
        title: name,
        x: Axis::linear("noise, edge lengths", [0.0, 0.85]),
        y: Axis::log("error of the size, %", [0.008, 40.0], &[0.01, 0.1, 1.0, 10.0]),
        // Without noise errors are zero, which has no logarithm.
        series: lines(table, "noise", &rows, &methods)
            .into_iter()
            .map(|series| Series {
                points: series.points.into_iter().filter(|p| p[1] >= 0.008).collect(),
                ..series
            })
            .collect(),
        notes: Vec::new(),
    });
    Figure::of_charts(4, [260.0, 230.0], charts.collect())
}

/// Accuracy over the number of cells.
pub fn cells(table: &Table) -> Figure {
    let rows: Vec<usize> = (0..table.n_rows()).collect();
    let chart = Chart {
        title: "Gsh with the SVM alone".to_owned(),
        x: Axis::log("cells of the sphere", [47.0, 440.0], &[52.0, 102.0, 202.0, 402.0]),
        y: Axis::linear("named right, %", [80.0, 100.0]),
        series: lines(table, "cells", &rows, &["with skewness", "without"]),
        notes: Vec::new(),
    };
    Figure::of_charts(1, [460.0, 290.0], vec![chart])
}

/// The parameters that were best in each fold.
pub fn folds(table: &Table) -> Figure {
    let exponents = |name: &str| -> Vec<f64> {
        table.column(name).iter().map(|cell| cell.trim_start_matches("2^").parse().unwrap_or(0.0)).collect()
    };
    let (c, gamma) = (exponents("C"), exponents("gamma"));
    let points: Vec<[f64; 2]> = c.iter().zip(&gamma).map(|(c, gamma)| [*c, *gamma]).collect();
    let mut places = points.clone();
    places.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    places.dedup();
    let folds_at = |place: &[f64; 2]| {
        let at = (0..points.len()).filter(|k| points[*k] == *place).map(|k| (k + 1).to_string());
        at.collect::<Vec<_>>().join(", ")
    };
    let notes = places.iter().map(|place| ([place[0], place[1] + 0.15], folds_at(place))).collect();
    let chart = Chart {
        title: "Best of folds 1 to 10".to_owned(),
        x: Axis::linear("C, exponent of two", [-6.0, 16.0]),
        y: Axis::linear("gamma, exponent of two", [-16.0, 4.0]),
        series: vec![Series { name: String::new(), color: 0, mark: Mark::Dots, points: places.clone() }],
        notes,
    };
    Figure::of_charts(1, [460.0, 320.0], vec![chart])
}

/// Least, mean and greatest of each statistic, by class.
pub fn statistics(table: &Table) -> Figure {
    let groups: Vec<String> = table
        .column("class")
        .iter()
        .map(|name| name.split(' ').map(|word| &word[..word.len().min(8)]).collect::<Vec<_>>().join("\n"))
        .collect();
    let charts = [
        ("offset", [0.0, 1.05]),
        ("flatness", [0.0, 0.65]),
        ("spread, degrees", [0.0, 190.0]),
        ("skewness", [-3.0, 15.0]),
    ]
    .map(|(name, range)| {
        let mut series = Vec::new();
        let mut means = Vec::new();
        for (k, cell) in table.column(name).iter().enumerate() {
            let values: Vec<f64> = cell.split(" / ").filter_map(|v| v.parse().ok()).collect();
            let [least, mean, greatest] = values[..] else { continue };
            let points = vec![[k as f64, least], [k as f64, greatest]];
            series.push(Series { name: String::new(), color: 5, mark: Mark::Line, points });
            means.push([k as f64, mean]);
        }
        series.push(Series { name: "mean".to_owned(), color: 0, mark: Mark::Dots, points: means });
        if let Some(range) = series.first_mut() {
            "least to greatest".clone_into(&mut range.name);
        }
        Chart {
            title: name.to_owned(),
            x: Axis::names("", &groups),
            y: Axis::linear(name, range),
            series,
            notes: Vec::new(),
        }
    });
    Figure::of_charts(2, [640.0, 240.0], charts.into())
}

/// Skewness of spheres and tori, a panel per triangulation and vote: name, values of spheres, values of tori.
pub fn skewness(panels: &[(String, Vec<f64>, Vec<f64>)]) -> Figure {
    let charts = panels.iter().map(|(name, spheres, tori)| {
        let dots = |what: &str, color, values: &[f64]| Series {
            name: what.to_owned(),
            color,
            mark: Mark::Dots,
            points: values.iter().enumerate().map(|(k, v)| [k as f64 + 1.0, *v]).collect(),
        };
        let limit = vec![[0.0, 1.5], [101.0, 1.5]];
        Chart {
            title: name.clone(),
            x: Axis::linear("model", [0.0, 101.0]),
            y: Axis::linear("skewness", [-1.0, 9.0]),
            series: vec![
                dots("spheres", 0, spheres),
                dots("tori", 1, tori),
                Series { name: "limit of the rules".to_owned(), color: 2, mark: Mark::Dashes, points: limit },
            ],
            notes: Vec::new(),
        }
    });
    Figure::of_charts(2, [420.0, 250.0], charts.collect())
}

/// Sorted histograms of spheres and of tori.
pub fn histograms(spheres: &[Vec<f64>], tori: &[Vec<f64>]) -> Figure {
    let curves = |what: &str, color, histograms: &[Vec<f64>]| {
        let curve = |(k, votes): (usize, &Vec<f64>)| Series {
            name: if k == 0 { what.to_owned() } else { String::new() },
            color,
            mark: Mark::Hair,
            points: votes.iter().enumerate().map(|(place, vote)| [place as f64 + 1.0, *vote]).collect(),
        };
        histograms.iter().enumerate().map(curve).collect::<Vec<_>>()
    };
    let chart = Chart {
        title: "Votes of the 202 cells, sorted".to_owned(),
        x: Axis::log("place", [0.95, 210.0], &[1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 202.0]),
        y: Axis::linear("votes over their mean", [0.0, 12.0]),
        series: [curves("10 tori", 1, tori), curves("10 spheres", 0, spheres)]
            .into_iter()
            .flatten()
            .collect(),
        notes: Vec::new(),
    };
    Figure::of_charts(1, [560.0, 340.0], vec![chart])
}

/// A class, with histograms of complete and of partial models.
pub type Histograms<'a> = (&'a str, Vec<Vec<f64>>, Vec<Vec<f64>>);

/// Distributions of distances of some complete and partial models of each class.
pub fn distances(classes: &[Histograms]) -> Figure {
    let width = D2_REACH / D2_BINS as f64;
    let shares = classes.iter().flat_map(|class| class.1.iter().chain(&class.2)).flatten();
    let highest = 100.0 * shares.fold(0.0, |highest: f64, share| highest.max(*share));
    let charts = classes.iter().map(|(name, complete, partial)| {
        let curves = |what: &str, color, histograms: &[Vec<f64>]| {
            let curve = |(k, shares): (usize, &Vec<f64>)| Series {
                name: if k == 0 { what.to_owned() } else { String::new() },
                color,
                mark: Mark::Hair,
                points: shares
                    .iter()
                    .enumerate()
                    .map(|(bin, share)| [(bin as f64 + 0.5) * width, 100.0 * share])
                    .collect(),
            };
            histograms.iter().enumerate().map(curve).collect::<Vec<_>>()
        };
        Chart {
            title: (*name).to_owned(),
            x: Axis::linear("distance over its mean", [0.0, 3.0]),
            y: Axis::linear("pairs, %", [0.0, 1.02 * highest]),
            series: [curves("complete", 0, complete), curves("partial", 1, partial)]
                .into_iter()
                .flatten()
                .collect(),
            notes: Vec::new(),
        }
    });
    Figure::of_charts(3, [300.0, 230.0], charts.collect())
}
