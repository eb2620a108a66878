//! Round values: grids in millimetres, inches and degrees, and the diameters of holes for metric threads.

/// Spacings of round lengths in millimetres, coarsest first.
pub(super) const METRIC: [(f64, &str); 8] = [
    (10.0, "10 mm"),
    (5.0, "5 mm"),
    (2.0, "2 mm"),
    (1.0, "1 mm"),
    (0.5, "0.5 mm"),
    (0.25, "0.25 mm"),
    (0.1, "0.1 mm"),
    (0.05, "0.05 mm"),
];

/// Millimetres of an inch.
pub(super) const INCH: f64 = 25.4;

/// Spacings of round lengths in inches, coarsest first.
pub(super) const INCHES: [(f64, &str); 7] = [
    (1.0, "1 inch"),
    (1.0 / 2.0, "1/2 inch"),
    (1.0 / 4.0, "1/4 inch"),
    (1.0 / 8.0, "1/8 inch"),
    (1.0 / 16.0, "1/16 inch"),
    (1.0 / 32.0, "1/32 inch"),
    (1.0 / 64.0, "1/64 inch"),
];

/// Spacings of round angles in degrees, coarsest first.
pub(super) const DEGREES: [(f64, &str); 4] =
    [(15.0, "15 degrees"), (5.0, "5 degrees"), (1.0, "1 degree"), (0.5, "0.5 degrees")];

/// Diameters of holes for metric threads, millimetres, ascending: clearance holes of the medium series (ISO 273) and tap drills
/// of the coarse pitch series (ISO 2306).
pub(super) const HOLES: [(f64, &str); 24] = [
    (1.6, "M2 tap drill"),
    (2.05, "M2.5 tap drill"),
    (2.4, "M2 clearance hole"),
    (2.5, "M3 tap drill"),
    (2.9, "M2.5 clearance hole"),
    (3.3, "M4 tap drill"),
    (3.4, "M3 clearance hole"),
    (4.2, "M5 tap drill"),
    (4.5, "M4 clearance hole"),
    (5.0, "M6 tap drill"),
    (5.5, "M5 clearance hole"),
    (6.6, "M6 clearance hole"),
    (6.8, "M8 tap drill"),
    (8.5, "M10 tap drill"),
    (9.0, "M8 clearance hole"),
    (10.2, "M12 tap drill"),
    (11.0, "M10 clearance hole"),
    (13.5, "M12 clearance hole"),
    (14.0, "M16 tap drill"),
    (17.5, "M16 clearance hole, M20 tap drill"),
    (21.0, "M24 tap drill"),
    (22.0, "M20 clearance hole"),
    (26.0, "M24 clearance hole"),
    (33.0, "M30 clearance hole"),
];
