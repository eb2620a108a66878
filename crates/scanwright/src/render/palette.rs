use crate::surface::SurfaceKind;

/// An sRGB color.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(pub [u8; 3]);

impl Color {
    /// The scan itself.
    pub const SCAN: Self = Self([208, 208, 204]);
    /// No analytic surface.
    pub const FREEFORM: Self = Self([214, 196, 120]);
    /// Triangles that belong to no region.
    pub const NONE: Self = Self([150, 150, 152]);
    /// What surrounds a marked place.
    pub const PLAIN: Self = Self([216, 218, 220]);
    /// A marked place.
    pub const MARK: Self = Self([214, 40, 110]);
    /// The supporting table.
    pub const TABLE: Self = Self([226, 226, 224]);

    /// What no scan showed.
    pub const UNSEEN: Self = Self([176, 132, 196]);
    /// A face that is not there.
    pub const ABSENT: Self = Self([72, 40, 72]);

    /// The color mixed with white: faces that were assumed.
    #[must_use]
    pub fn pale(self) -> Self {
        Self(self.0.map(|c| 255 - (255 - c) / 2))
    }

    /// As HTML and SVG write it.
    pub fn hex(self) -> String {
        let [r, g, b] = self.0;
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// Red, green and blue in linear light, 0 to 1.
    pub(super) fn linear(self) -> [f32; 3] {
        self.0.map(|c| {
            let c = f32::from(c) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }
}

/// Behind everything.
pub(super) const BACKGROUND: Color = Color([250, 250, 248]);
/// Letters.
pub(super) const INK: Color = Color([64, 66, 70]);

/// Linear light as an sRGB byte.
pub(super) fn encode(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let c = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (255.0 * c).round() as u8
}

/// The color of a surface type, the same in every picture; freeform without one.
pub fn of_kind(kind: Option<SurfaceKind>) -> Color {
    match kind {
        Some(SurfaceKind::Plane) => Color([112, 160, 208]),
        Some(SurfaceKind::Cylinder) => Color([238, 152, 82]),
        Some(SurfaceKind::Cone) => Color([112, 184, 120]),
        Some(SurfaceKind::Sphere) => Color([218, 104, 128]),
        Some(SurfaceKind::Torus) => Color([152, 124, 200]),
        None => Color::FREEFORM,
    }
}

/// A scale from blue (negative) over pale grey (zero) to orange and brown (positive), which people who do not tell red from
/// green read as well. Lightness falls the same way on both sides. What is beyond the ends has a color of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diverging {
    /// The value at the positive end; the negative end is its opposite.
    pub limit: f64,
}

impl Diverging {
    /// Beyond the negative and the positive end.
    pub const BEYOND: [Color; 2] = [Color([28, 24, 92]), Color([96, 20, 12])];

    /// The color of a value; grey without one.
    pub fn color(&self, value: f64) -> Color {
        const LIGHTNESS: (f64, f64) = (0.93, 0.56);
        const CHROMA: f64 = 0.155;
        const HUES: [f64; 2] = [4.40, 0.86];
        if value.is_nan() {
            return Color::NONE;
        }
        let side = usize::from(value > 0.0);
        let share = (value / self.limit).abs();
        if share > 1.0 {
            return Self::BEYOND[side];
        }
        oklch(LIGHTNESS.0 + (LIGHTNESS.1 - LIGHTNESS.0) * share, CHROMA * share.powf(0.8), HUES[side])
    }
}

/// A color per region: hues a golden angle apart, so that neighbours in number differ most.
pub fn of_region(region: usize) -> Color {
    const GOLDEN_TURN: f64 = 0.618_033_988_749_895;
    let hue = std::f64::consts::TAU * (region as f64 * GOLDEN_TURN).fract();
    // Three lightness levels keep neighbours apart where hues come round again.
    let lightness = [0.72, 0.80, 0.64][region % 3];
    oklch(lightness, 0.115, hue)
}

/// B. Ottosson, "A perceptual color space for image processing" (2020): Oklab from lightness, chroma and hue.
fn oklch(lightness: f64, chroma: f64, hue: f64) -> Color {
    let (a, b) = (chroma * hue.cos(), chroma * hue.sin());
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    let red = 4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s;
    let green = -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s;
    let blue = -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s;
    Color([red, green, blue].map(|c| encode(c as f32)))
}
