use super::Image;

/// The bytes of an 8-bit RGB PNG file.
pub(super) fn encode(image: &Image) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Writing to memory cannot fail; a picture of zero size is the one thing the format refuses.
    let mut writer = encoder.write_header().expect("a picture has at least one pixel");
    writer.write_image_data(&image.pixels).expect("three bytes per pixel were made");
    drop(writer);
    bytes
}
