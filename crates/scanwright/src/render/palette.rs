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

/// The color of a deviation, as a share of the end of the scale: blue inside, grey at zero, red outside.
pub fn of_deviation(share: f64) -> Color {
    const ENDS: [[f64; 3]; 3] = [[38.0, 92.0, 190.0], [222.0, 222.0, 218.0], [204.0, 54.0, 44.0]];
    let share = share.clamp(-1.0, 1.0);
    let end = if share < 0.0 { ENDS[0] } else { ENDS[2] };
    let mix = |k: usize| (ENDS[1][k] + (end[k] - ENDS[1][k]) * share.abs()).round() as u8;
    Color([mix(0), mix(1), mix(2)])
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
