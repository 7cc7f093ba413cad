//! Plots as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::normality::{Distribution, quantile};
use crate::fit::{FitError, FitResult};

/// Colours that the colour-blind tell apart (Okabe and Ito 2008).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(70, 70, 70),
];
const FONT: &str = "sans-serif";
const SIZE: (u32, u32) = (640, 400);

/// A line of a chart.
pub struct Line {
    /// What it is.
    pub name: String,
    /// Which of the colours; lines of one thing have one colour.
    pub colour: usize,
    /// Whether it is drawn broken.
    pub broken: bool,
    /// Its points, by increasing x.
    pub points: Vec<(f64, f64)>,
}

/// What is on the axes.
pub struct Axes<'a> {
    /// Above the chart.
    pub title: &'a str,
    /// Below it.
    pub x: &'a str,
    /// Beside it.
    pub y: &'a str,
    /// The largest y that is shown; the largest there is without.
    pub highest: Option<f64>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn svg(size: (u32, u32), draw: impl FnOnce(&Area) -> Drawn) -> FitResult<String> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE)
            .and_then(|()| draw(&area))
            .and_then(|()| area.present())
            .map_err(|e| FitError::Input(format!("a plot could not be drawn: {e}")))?;
    }
    Ok(text)
}

type Drawn = Result<(), DrawingAreaErrorKind<<SVGBackend<'static> as DrawingBackend>::ErrorType>>;

/// Lines over common axes that start at zero.
pub fn lines(axes: &Axes, all: &[Line]) -> FitResult<String> {
    let points = || all.iter().flat_map(|line| &line.points);
    let right = points().fold(0.0_f64, |m, p| m.max(p.0)).max(1e-9);
    let top = points().fold(0.0_f64, |m, p| m.max(p.1)).max(1e-9);
    let top = axes.highest.unwrap_or(1.05 * top);
    svg(SIZE, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(axes.title, (FONT, 17))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(52)
            .build_cartesian_2d(0.0..right, 0.0..top)?;
        chart
            .configure_mesh()
            .x_desc(axes.x)
            .y_desc(axes.y)
            .axis_desc_style((FONT, 14))
            .label_style((FONT, 12))
            .light_line_style(WHITE)
            .draw()?;
        for line in all {
            let colour = COLOURS[line.colour % COLOURS.len()];
            let style = colour.stroke_width(2);
            let shown = line.points.iter().copied().filter(|p| p.1 <= top);
            let drawn = if line.broken {
                chart.draw_series(DashedLineSeries::new(shown, 6, 4, style))?
            } else {
                chart.draw_series(LineSeries::new(shown, style))?
            };
            let broken = line.broken;
            drawn.label(&line.name).legend(move |(x, y)| {
                let end = if broken { x + 9 } else { x + 22 };
                PathElement::new([(x, y), (end, y)], style)
            });
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .label_font((FONT, 12))
            .draw()
    })
}

/// A bar for each name.
pub fn bars(axes: &Axes, values: &[(String, f64)]) -> FitResult<String> {
    let top = values.iter().fold(0.0_f64, |m, v| m.max(v.1)).max(1e-9) * 1.1;
    svg((SIZE.0 / 2, 260), |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(axes.title, (FONT, 15))
            .margin(10)
            .x_label_area_size(36)
            .y_label_area_size(44)
            .build_cartesian_2d((0..values.len() as i32 - 1).into_segmented(), 0.0..top)?;
        let name = |at: &SegmentValue<i32>| match at {
            SegmentValue::CenterOf(i) | SegmentValue::Exact(i) => values
                .get(*i as usize)
                .map_or(String::new(), |v| v.0.clone()),
            SegmentValue::Last => String::new(),
        };
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(values.len())
            .x_label_formatter(&name)
            .x_desc(axes.x)
            .y_desc(axes.y)
            .axis_desc_style((FONT, 12))
            .label_style((FONT, 11))
            .light_line_style(WHITE)
            .draw()?;
        let shown = values.iter().enumerate().map(|(i, v)| (i as i32, v.1));
        chart.draw_series(
            Histogram::vertical(&chart)
                .style(COLOURS[0].filled())
                .margin(4)
                .data(shown),
        )?;
        Ok(())
    })
}

/// How many numbers fall into each of `count` equal intervals, named by their middles.
pub fn histogram(values: &[f64], count: usize) -> Vec<(String, f64)> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let step = ((high - low) / count as f64).max(1e-12);
    let mut counts = vec![0.0; count];
    for v in values {
        counts[(((v - low) / step) as usize).min(count - 1)] += 1.0;
    }
    (counts.into_iter().enumerate())
        .map(|(i, n)| (format!("{:.1}", low + (i as f64 + 0.5) * step), n))
        .collect()
}

/// Quantiles of coefficients against those of a normal distribution, a panel each.
pub fn quantiles(distributions: &[&Distribution], columns: usize) -> FitResult<String> {
    let rows = distributions.len().div_ceil(columns);
    let size = (columns as u32 * 170, rows as u32 * 170);
    svg(size, |area| {
        for (panel, distribution) in area.split_evenly((rows, columns)).iter().zip(distributions) {
            let title = format!("{} ({:.3})", distribution.control, distribution.distance);
            let mut chart = ChartBuilder::on(panel)
                .caption(title, (FONT, 12))
                .margin(4)
                .x_label_area_size(16)
                .y_label_area_size(20)
                .build_cartesian_2d(-3.5..3.5, -3.5..3.5)?;
            chart
                .configure_mesh()
                .disable_mesh()
                .x_labels(5)
                .y_labels(5)
                .label_style((FONT, 9))
                .draw()?;
            let straight = [(-3.5, -3.5), (3.5, 3.5)];
            chart.draw_series(LineSeries::new(straight, RGBColor(190, 190, 190)))?;
            let n = distribution.sorted.len() as f64;
            let points = (distribution.sorted.iter().enumerate())
                .map(|(i, &v)| (quantile((i as f64 + 0.5) / n), v))
                .filter(|p| p.1.abs() < 3.5);
            chart.draw_series(points.map(|p| Circle::new(p, 1, COLOURS[0].filled())))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_every_number_once() {
        let bars = histogram(&[0.0, 0.1, 0.5, 0.99, 1.0], 2);
        assert_eq!(bars[0], ("0.2".into(), 2.0));
        assert_eq!(bars[1], ("0.8".into(), 3.0));
        assert_eq!(
            histogram(&[3.0; 4], 3).iter().map(|b| b.1).sum::<f64>(),
            4.0
        );
    }

    #[test]
    fn a_plot_is_svg_with_its_words() {
        let axes = Axes {
            title: "variance",
            x: "modes",
            y: "part",
            highest: None,
        };
        let line = Line {
            name: "nose".into(),
            colour: 0,
            broken: true,
            points: vec![(1.0, 0.5), (2.0, 0.9)],
        };
        let text = lines(&axes, &[line]).unwrap();
        for word in ["<svg", "variance", "modes", "part", "nose", "</svg>"] {
            assert!(text.contains(word), "{word}");
        }
        assert!(bars(&axes, &[("a".into(), 1.0)]).unwrap().contains("<rect"));
    }
}
