//! Pictures on their way: one a stream, a header and the bytes of the file.
//!
//! | bytes | field, lowest byte first |
//! |---|---|
//! | 4 | `TPIC` |
//! | 1 | camera |
//! | 4 | session |
//! | 4 | sequence |
//! | 8 | when it was taken, sender's clock, microseconds |
//! | 2, 2 | width and height, px |
//! | the rest | the JPEG file |

const MAGIC: [u8; 4] = *b"TPIC";

/// Bytes before the file.
const HEADER_LEN: usize = 4 + 1 + 4 + 4 + 8 + 2 + 2;

/// The longest file, bytes: far above a JPEG of 1920x1080 at its best quality.
const MAX_JPEG_LEN: usize = 4 * 1024 * 1024;

/// The longest stream, bytes.
pub const MAX_PICTURE_LEN: usize = HEADER_LEN + MAX_JPEG_LEN;

/// One camera's picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The camera's place among the sender's.
    pub camera: u8,
    /// Chosen anew each time the sender starts.
    pub session: u32,
    /// Counts the camera's pictures from 0, and wraps.
    pub sequence: u32,
    /// When it was taken, on the sender's clock, microseconds.
    pub capture_us: u64,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// The file.
    pub jpeg: Vec<u8>,
}

/// Why bytes are no picture, or a picture is not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// They end within the header, or begin otherwise.
    #[error("the stream is no picture")]
    NoPicture,
    /// The file is longer than is allowed.
    #[error("the picture is longer than {MAX_JPEG_LEN} bytes: send a smaller one, or one of less quality")]
    TooLong,
}

impl Picture {
    /// The bytes that cross the link.
    ///
    /// # Errors
    /// [`PictureError::TooLong`]
    pub fn encode(&self) -> Result<Vec<u8>, PictureError> {
        if self.jpeg.len() > MAX_JPEG_LEN {
            return Err(PictureError::TooLong);
        }
        Ok([
            &MAGIC[..],
            &[self.camera],
            &self.session.to_le_bytes(),
            &self.sequence.to_le_bytes(),
            &self.capture_us.to_le_bytes(),
            &self.width.to_le_bytes(),
            &self.height.to_le_bytes(),
            &self.jpeg,
        ]
        .concat())
    }

    /// Reads a whole stream.
    ///
    /// # Errors
    /// [`PictureError`]
    pub fn decode(bytes: &[u8]) -> Result<Self, PictureError> {
        let picture = Self::parse(bytes).ok_or(PictureError::NoPicture)?;
        if picture.jpeg.len() > MAX_JPEG_LEN { Err(PictureError::TooLong) } else { Ok(picture) }
    }

    fn parse(bytes: &[u8]) -> Option<Self> {
        let rest = bytes.strip_prefix(&MAGIC)?;
        let (&camera, rest) = rest.split_first()?;
        let (session, rest) = rest.split_first_chunk()?;
        let (sequence, rest) = rest.split_first_chunk()?;
        let (capture, rest) = rest.split_first_chunk()?;
        let (width, rest) = rest.split_first_chunk()?;
        let (height, jpeg) = rest.split_first_chunk()?;
        Some(Self {
            camera,
            session: u32::from_le_bytes(*session),
            sequence: u32::from_le_bytes(*sequence),
            capture_us: u64::from_le_bytes(*capture),
            width: u16::from_le_bytes(*width),
            height: u16::from_le_bytes(*height),
            jpeg: jpeg.to_vec(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_and_nothing_else_is_one() {
        let picture = Picture {
            camera: 1,
            session: 2,
            sequence: 3,
            capture_us: u64::MAX,
            width: 640,
            height: 480,
            jpeg: vec![0xFF, 0xD8, 7],
        };
        let bytes = picture.encode().unwrap();
        assert_eq!(bytes.len(), HEADER_LEN + 3);
        assert_eq!(Picture::decode(&bytes), Ok(picture.clone()));
        for len in 0..HEADER_LEN {
            assert_eq!(Picture::decode(&bytes[..len]), Err(PictureError::NoPicture), "{len}");
        }
        let mut other = bytes;
        other[0] = b'X';
        assert_eq!(Picture::decode(&other), Err(PictureError::NoPicture));
        let long = Picture { jpeg: vec![0; MAX_JPEG_LEN + 1], ..picture };
        assert_eq!(long.encode(), Err(PictureError::TooLong));
    }
}
