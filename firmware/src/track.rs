//! Pictures and commands to packets.

use crate::handover::{Begin, Buffers, Input, Inputs, Packets};
use crate::log;
use tetrad_core::node::Node;

/// Does what comes, in the order in which it comes; ends behind the last picture of a recording, or with the one
/// who begins with a new camera.
///
/// `now_us` is the clock of the pictures; where it has none, because they are recorded, each counts as
/// observed when it was ready. `good` is called after every picture that was looked at: what feeds a
/// watchdog.
pub async fn track(
    node: &mut Node,
    inputs: &Inputs,
    buffers: &Buffers,
    packets: &Packets,
    now_us: impl Fn() -> Option<u64>,
    mut good: impl FnMut(),
) -> Option<Begin> {
    loop {
        let notice = match inputs.receive().await {
            Input::Picture(picture) => {
                let captured = picture.captured;
                let seen =
                    picture.view().map(|view| node.picture(&view, captured.capture_us, captured.ready_us));
                buffers.send(picture.buffer).await;
                match seen {
                    Ok(seen) => {
                        good();
                        // (a loop over the vector itself has a panic path)
                        for notice in &seen.notices {
                            log::notice(notice);
                            packets.send(Some((*notice).into())).await;
                        }
                        if let Some(mut observation) = seen.observation {
                            let now_us =
                                now_us().unwrap_or(captured.capture_us + u64::from(captured.ready_us));
                            let after_us = now_us.saturating_sub(captured.capture_us);
                            observation.observed_us = u32::try_from(after_us).unwrap_or(u32::MAX);
                            packets.send(Some(observation.into())).await;
                        }
                        if let Some(strip) = seen.preview {
                            packets.send(Some(strip.into())).await;
                        }
                        None
                    }
                    Err(error) => Some(node.refuse(error.into())),
                }
            }
            Input::BadPicture(why) => Some(node.refuse(why)),
            Input::Command(command) => node.command(&command),
            Input::NotUnderstood => Some(node.not_understood()),
            Input::LineOverrun => Some(node.line_overrun()),
            Input::End => {
                packets.send(None).await;
                return None;
            }
            Input::Begin(begin) => return Some(begin),
        };
        if let Some(notice) = notice {
            log::notice(&notice);
            packets.send(Some(notice.into())).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::handover::{Captured, PICTURE_BYTES, Picture, PictureBuffer};
    use core::cell::Cell;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};
    use std::boxed::Box;
    use tetrad_core::config::{LearnConfig, TrackerConfig};
    use tetrad_core::node::NodeConfig;
    use tetrad_core::vision::frame::PixelFormat;
    use tetrad_core::wire::{BadPicture, Command, CommandPacket};

    fn picture(length: usize) -> Input {
        let (width, height, format) = (320, 240, PixelFormat::Rgb565Be);
        let captured = Captured { length, width, height, format, capture_us: 0, ready_us: 0 };
        Input::Picture(Picture { buffer: Box::leak(Box::new(PictureBuffer::new())), captured })
    }

    /// How often the watchdog is fed, and how many packets come, of one input.
    fn fed_by(input: Input) -> (u32, usize) {
        let (inputs, buffers, packets) = (Inputs::new(), Buffers::new(), Packets::new());
        let (tracker, learn) = (TrackerConfig::default(), LearnConfig::default());
        let config = NodeConfig { camera: 0, session: 1, tracker, learn, started: true };
        let mut node = Node::new(&config).unwrap();
        let fed = Cell::new(0);
        let tracking = track(&mut node, &inputs, &buffers, &packets, || None, || fed.set(fed.get() + 1));
        assert!(inputs.try_send(input).is_ok());
        assert_eq!(pin!(tracking).poll(&mut Context::from_waker(Waker::noop())), Poll::Pending);
        let count = core::iter::from_fn(|| packets.try_receive().ok()).count();
        (fed.get(), count)
    }

    #[test]
    fn the_watchdog_is_fed_by_pictures_that_were_looked_at_alone() {
        assert_eq!(fed_by(picture(PICTURE_BYTES)), (1, 1), "an observation");
        assert_eq!(fed_by(picture(PICTURE_BYTES - 2)), (0, 1), "a notice that it was refused");
        assert_eq!(fed_by(picture(PICTURE_BYTES + 2)), (0, 1));
        assert_eq!(fed_by(Input::BadPicture(BadPicture::Overrun)), (0, 1));
        let command = CommandPacket { session: 1, sequence: 0, command: Command::Stop };
        assert_eq!(fed_by(Input::Command(command)), (0, 1));
        assert_eq!(fed_by(Input::NotUnderstood), (0, 1));
        assert_eq!(fed_by(Input::LineOverrun), (0, 1));
    }
}
