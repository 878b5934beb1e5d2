//! What SRC may be, told apart by its looks and by what lies on the disk.

use std::path::{Path, PathBuf};

use tetrad_core::vision::frame::PixelFormat;

use super::SourceError;

/// SRC, understood but not opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Spec {
    /// A camera device: `/dev/videoN`, or a stable name such as `/dev/v4l/by-id/...`.
    Camera(PathBuf),
    /// A folder of numbered pictures.
    Folder(PathBuf),
    /// A YUV4MPEG2 film.
    Y4m(PathBuf),
    /// A recorded session.
    Mcap(PathBuf),
    /// A rendered scene, `sim:NAME` or `sim:NAME?format=yuyv`.
    Simulated {
        /// The scene's name.
        name: String,
        /// The pixel format its pictures are handed out in; RGB when not asked for.
        format: PixelFormat,
    },
}

/// Names accepted after `sim:NAME?format=`.
const FORMAT_NAMES: [(&str, PixelFormat); 8] = [
    ("rgb", PixelFormat::Rgb888),
    ("bgr", PixelFormat::Bgr888),
    ("rgba", PixelFormat::Rgba8888),
    ("rgb565le", PixelFormat::Rgb565Le),
    ("rgb565be", PixelFormat::Rgb565Be),
    ("yuyv", PixelFormat::Yuyv),
    ("uyvy", PixelFormat::Uyvy),
    ("nv12", PixelFormat::Nv12),
];

impl Spec {
    /// Understands SRC. Looks at the disk only to tell a folder from a file.
    ///
    /// # Errors
    /// [`SourceError::BadArgument`] saying what SRC may be.
    pub fn parse(spec: &str) -> Result<Self, SourceError> {
        if let Some(scene) = spec.strip_prefix("sim:") {
            return Self::parse_scene(spec, scene);
        }
        if spec.starts_with("node:") {
            return Err(SourceError::argument(
                spec,
                "what tracks by itself sends no pictures: name it under [[operator.camera]] in a tetrad.toml, and here give a camera, a folder, a .y4m or .mcap file or sim:NAME. `tetrad track --left node:serial:DEVICE`, without --right, takes a smart camera alone",
            ));
        }
        let path = Path::new(spec);
        if path.starts_with("/dev") {
            return Ok(Self::Camera(path.to_owned()));
        }
        if path.is_dir() {
            return Ok(Self::Folder(path.to_owned()));
        }
        let extension = path.extension().and_then(|text| text.to_str()).unwrap_or("").to_ascii_lowercase();
        if !path.exists() {
            return Err(SourceError::argument(
                spec,
                "no such file or folder: SRC is /dev/videoN, a folder of numbered PNG or JPEG frames, a .y4m or .mcap file or sim:NAME",
            ));
        }
        match extension.as_str() {
            "y4m" => Ok(Self::Y4m(path.to_owned())),
            "mcap" => Ok(Self::Mcap(path.to_owned())),
            "png" | "jpg" | "jpeg" => {
                Err(SourceError::argument(spec, "this is a single picture: give the folder it lies in"))
            }
            _ => Err(SourceError::argument(
                spec,
                format!(
                    "not a kind of file that is read here: convert a film with `ffmpeg -i {spec} -pix_fmt yuv420p film.y4m` and give film.y4m"
                ),
            )),
        }
    }

    fn parse_scene(spec: &str, scene: &str) -> Result<Self, SourceError> {
        let (name, query) = scene.split_once('?').unwrap_or((scene, ""));
        let mut format = PixelFormat::Rgb888;
        for pair in query.split('&').filter(|pair| !pair.is_empty()) {
            let Some(value) = pair.strip_prefix("format=") else {
                return Err(SourceError::argument(
                    spec,
                    format!("'{pair}' means nothing here: a scene takes only ?format=..."),
                ));
            };
            format = FORMAT_NAMES
                .iter()
                .find(|(known, _)| *known == value)
                .map(|(_, format)| *format)
                .ok_or_else(|| {
                    let known: Vec<&str> = FORMAT_NAMES.iter().map(|(known, _)| *known).collect();
                    SourceError::argument(
                        spec,
                        format!("'{value}' is no pixel format: give one of {}", known.join(", ")),
                    )
                })?;
        }
        Ok(Self::Simulated { name: name.to_owned(), format })
    }
}
