//! Pictures of a palette of 256 colours as PNG (ISO/IEC 15948).

use std::io::Write;

use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};

use super::shade::shade;

/// A picture, row after row from the top; each pixel is a share of the colour scale in 255ths.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<u8>,
}

impl Picture {
    /// The picture as a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let size = |length: usize| u32::try_from(length).unwrap_or(u32::MAX).to_be_bytes();
        // 8 bits of a palette, without interlacing.
        let head = [&size(self.width)[..], &size(self.height), &[8, 3, 0, 0, 0]].concat();
        let palette: Vec<u8> = (0..=255).flat_map(|level| shade(f64::from(level) / 255.0)).collect();
        let mut lines = ZlibEncoder::new(Vec::new(), Compression::default());
        for line in self.pixels.chunks(self.width.max(1)) {
            // Each line begins with the number of its filter: none. Writing to memory cannot fail.
            let _ = lines.write_all(&[0]).and_then(|()| lines.write_all(line));
        }
        let lines = lines.finish().unwrap_or_default();
        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        for (name, content) in [(b"IHDR", head), (b"PLTE", palette), (b"IDAT", lines), (b"IEND", Vec::new())] {
            let mut check = Crc::new();
            check.update(name);
            check.update(&content);
            file.extend(size(content.len()));
            file.extend(name);
            file.extend(content);
            file.extend(check.sum().to_be_bytes());
        }
        file
    }
}

/// Bytes in base64 (RFC 4648).
pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let word = (0..3).fold(0_u32, |word, k| word << 8 | u32::from(part.get(k).copied().unwrap_or(0)));
        for digit in 0..4 {
            let place = (word >> (18 - 6 * digit)) as usize & 63;
            text.push(if digit <= part.len() { char::from(DIGITS[place]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn a_picture_has_its_chunks_and_its_pixels() {
        let picture = Picture { width: 3, height: 2, pixels: vec![0, 1, 2, 253, 254, 255] };
        let file = picture.png();
        assert_eq!(file[..8], *b"\x89PNG\r\n\x1a\n");
        // The end of every PNG file.
        assert_eq!(file[file.len() - 12..], *b"\0\0\0\0IEND\xae\x42\x60\x82");
        let data = file.windows(4).position(|name| name == b"IDAT").unwrap() + 4;
        let mut lines = Vec::new();
        flate2::read::ZlibDecoder::new(&file[data..]).read_to_end(&mut lines).unwrap();
        assert_eq!(lines, [0, 0, 1, 2, 0, 253, 254, 255]);
    }

    #[test]
    fn base64_of_the_standard() {
        for (bytes, text) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
