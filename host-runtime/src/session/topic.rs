//! What a session may hold: a topic for each kind of thing, and for each camera.

/// One topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// What the session began with: the first message.
    Configuration,
    /// A camera's pictures, as they were captured.
    Image(usize),
    /// What was seen in them.
    Observations(usize),
    /// The same, to be drawn over them.
    Annotations(usize),
    /// What it is to look for from a picture on: it was taught anew.
    Taught(usize),
    /// The hand is another from here on: it was set up anew.
    HandBegins,
    /// When an operator asked for an instant, and what it got.
    Instant,
    /// The hand to the bit.
    Hand,
    /// Its measured pose.
    Pose,
    /// Its filtered pose.
    Filtered,
    /// What the slave was told.
    Command,
    /// The operator's buttons.
    Buttons,
    /// What the slave said.
    Arm,
    /// The arm's measured joints.
    Joints,
    /// The joints that it was told.
    SetPoint,
    /// Where hand and tool are, for a scene in three dimensions.
    Transforms,
    /// How long each stage took.
    Delays,
    /// What the program said.
    Log,
}

/// The topics that are not a camera's.
const SINGLE: [(Topic, &str, &str); 14] = [
    (Topic::Configuration, "/configuration", "tetrad.Configuration"),
    (Topic::HandBegins, "/hand/begins", "tetrad.HandBegins"),
    (Topic::Instant, "/hand/instant", "tetrad.Instant"),
    (Topic::Hand, "/hand", "tetrad.Hand"),
    (Topic::Pose, "/hand/pose", "foxglove.PoseInFrame"),
    (Topic::Filtered, "/hand/filtered", "foxglove.PoseInFrame"),
    (Topic::Command, "/command", "tetrad.Command"),
    (Topic::Buttons, "/buttons", "tetrad.Buttons"),
    (Topic::Arm, "/arm", "tetrad.Arm"),
    (Topic::Joints, "/arm/joints", "foxglove.JointStates"),
    (Topic::SetPoint, "/arm/set_point", "foxglove.JointStates"),
    (Topic::Transforms, "/tf", "foxglove.FrameTransform"),
    (Topic::Delays, "/delays", "tetrad.Delays"),
    (Topic::Log, "/log", "foxglove.Log"),
];

impl Topic {
    /// Its name; `cameras` are those of the configuration.
    #[must_use]
    pub fn name(self, cameras: &[String]) -> String {
        let of = |camera: usize, what: &str| {
            let name = cameras.get(camera).map_or("camera", String::as_str);
            format!("/{name}/{what}")
        };
        match self {
            Self::Image(camera) => of(camera, "image"),
            Self::Observations(camera) => of(camera, "observations"),
            Self::Annotations(camera) => of(camera, "annotations"),
            Self::Taught(camera) => of(camera, "taught"),
            single => SINGLE
                .iter()
                .find(|(topic, ..)| *topic == single)
                .map_or_else(String::new, |(_, name, _)| (*name).to_owned()),
        }
    }

    /// The full name of its messages' schema.
    #[must_use]
    pub fn schema(self) -> &'static str {
        match self {
            Self::Image(_) => "foxglove.RawImage",
            Self::Observations(_) => "tetrad.Observations",
            Self::Annotations(_) => "foxglove.ImageAnnotations",
            Self::Taught(_) => "tetrad.Taught",
            single => SINGLE.iter().find(|(topic, ..)| *topic == single).map_or("", |(_, _, schema)| schema),
        }
    }

    /// Every topic that a session of so many cameras may have.
    pub fn all(cameras: usize) -> impl Iterator<Item = Self> {
        let of_cameras = (0..cameras).flat_map(|at| {
            [Self::Image(at), Self::Observations(at), Self::Annotations(at), Self::Taught(at)]
        });
        SINGLE.iter().map(|(topic, ..)| *topic).chain(of_cameras)
    }

    /// The topic of that name.
    #[must_use]
    pub fn of_name(name: &str, cameras: &[String]) -> Option<Self> {
        Self::all(cameras.len()).find(|topic| topic.name(cameras) == name)
    }
}

/// Names for cameras as topics have them: letters, digits, `-` and `_` of what they are called, each
/// another than those before, and none that is a topic already.
#[must_use]
pub fn camera_names<'a>(called: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for called in called {
        let called = called.strip_prefix("node:").unwrap_or(called);
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
        let name: String = called.chars().map(plain).collect();
        let name = name.trim_matches('_');
        let name = if name.is_empty() { "camera" } else { name };
        let taken = |name: &str| {
            let topic = format!("/{name}");
            let single = SINGLE.iter().any(|(_, known, _)| *known == topic);
            single || names.iter().any(|known| known == name)
        };
        let mut free = name.to_owned();
        let mut number = names.len() + 1;
        while taken(&free) {
            free = format!("{name}_{number}");
            number += 1;
        }
        names.push(free);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_topic_is_found_by_its_name() {
        let cameras = camera_names(["left", "right"]);
        for topic in Topic::all(2) {
            let name = topic.name(&cameras);
            assert!(name.len() > 1 && !topic.schema().is_empty(), "{topic:?}");
            assert_eq!(Topic::of_name(&name, &cameras), Some(topic), "{name}");
        }
        assert_eq!(Topic::of_name("/rosout", &cameras), None);
    }

    #[test]
    fn cameras_have_names_of_their_own() {
        let names =
            camera_names(["left", "node:left", "/dev/video0", "hand", "", "node:serial:/dev/ttyACM0"]);
        let expected = ["left", "left_2", "dev_video0", "hand_4", "camera", "serial__dev_ttyACM0"];
        assert_eq!(names, expected);
    }
}
