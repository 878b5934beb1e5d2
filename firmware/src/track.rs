//! Pictures and commands to packets.

use crate::handover::{Buffers, Input, Inputs, Packets};
use tetrad_core::node::Node;

/// Does what comes, in the order in which it comes; ends behind the last picture of a recording.
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
) {
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
                            packets.send(Some((*notice).into())).await;
                        }
                        if let Some(mut observation) = seen.observation {
                            let now_us =
                                now_us().unwrap_or(captured.capture_us + u64::from(captured.ready_us));
                            let after_us = now_us.saturating_sub(captured.capture_us);
                            observation.observed_us = u32::try_from(after_us).unwrap_or(u32::MAX);
                            packets.send(Some(observation.into())).await;
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
                return;
            }
        };
        if let Some(notice) = notice {
            packets.send(Some(notice.into())).await;
        }
    }
}
