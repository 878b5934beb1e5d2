//! The .proto files, their descriptors and the messages that are written by hand say the same.

use super::*;
use prost::Message;
use protox::prost_reflect::{DescriptorPool, DynamicMessage, Kind, MessageDescriptor, Value};
use std::path::Path;

fn compiled() -> Vec<u8> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/session/proto");
    let mut files: Vec<String> = std::fs::read_dir(dir.join("foxglove"))
        .unwrap()
        .map(|file| format!("foxglove/{}", file.unwrap().file_name().to_string_lossy()))
        .collect();
    files.sort();
    files.push("tetrad.proto".to_owned());
    let mut compiler = protox::Compiler::new([&dir]).unwrap();
    compiler.include_imports(true);
    let files: Vec<_> = files.iter().map(|file| dir.join(file)).collect();
    compiler.open_files(files).unwrap();
    compiler.file_descriptor_set().encode_to_vec()
}

#[test]
fn the_descriptors_are_those_of_the_proto_files() {
    let compiled = compiled();
    if std::env::var_os("TETRAD_BLESS").is_some_and(|value| value == "1") {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/session/descriptors.bin");
        std::fs::write(file, &compiled).unwrap();
        return;
    }
    assert!(compiled == DESCRIPTORS, "run TETRAD_BLESS=1 cargo test -p tetrad session::schema and commit");
}

/// A message with every field set to something that is not its default.
fn filled(descriptor: &MessageDescriptor, depth: usize) -> DynamicMessage {
    let mut message = DynamicMessage::new(descriptor.clone());
    for field in descriptor.fields() {
        let number = field.number();
        let value = match field.kind() {
            Kind::Double => Value::F64(f64::from(number) + 0.25),
            Kind::Float => Value::F32(number as f32 + 0.5),
            Kind::Int32 => Value::I32(number as i32),
            Kind::Int64 => Value::I64(i64::from(number)),
            Kind::Uint32 | Kind::Fixed32 => Value::U32(number),
            Kind::Uint64 => Value::U64(u64::from(number)),
            Kind::Bool => Value::Bool(true),
            Kind::String => Value::String(format!("text {number}")),
            Kind::Bytes => Value::Bytes(vec![number as u8; 3].into()),
            Kind::Enum(known) => Value::EnumNumber(known.values().map(|v| v.number()).max().unwrap()),
            Kind::Message(inner) if depth < 5 => Value::Message(filled(&inner, depth + 1)),
            other => panic!("{}: {other:?} is used nowhere yet", field.full_name()),
        };
        let value = if field.is_list() { Value::List(vec![value.clone(), value]) } else { value };
        message.set_field(&field, value);
    }
    message
}

/// What `M` makes of a message with every field set is that message again, less the fields that Tetrad
/// does not write.
fn agrees<M: Message + Default>(name: &str, unused: &[&str]) {
    let pool = DescriptorPool::decode(DESCRIPTORS).unwrap();
    let descriptor = pool.get_message_by_name(name).unwrap_or_else(|| panic!("no descriptor of {name}"));
    let mut message = filled(&descriptor, 0);
    for field in unused {
        clear(&mut message, field);
    }
    let bytes = message.encode_to_vec();
    let through = M::decode(bytes.as_slice()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let back = DynamicMessage::decode(descriptor, through.encode_to_vec().as_slice()).unwrap();
    assert_eq!(back, message, "{name}");
}

/// Clears a field, `circles.metadata` in every message of a list.
fn clear(message: &mut DynamicMessage, path: &str) {
    match path.split_once('.') {
        None => message.clear_field_by_name(path),
        Some((head, rest)) => match message.get_field_by_name_mut(head).unwrap() {
            Value::List(all) => {
                all.iter_mut().filter_map(Value::as_message_mut).for_each(|inner| clear(inner, rest));
            }
            Value::Message(inner) => clear(inner, rest),
            other => panic!("{path}: {other:?}"),
        },
    }
}

#[test]
fn every_message_by_hand_has_the_fields_of_its_descriptor() {
    agrees::<foxglove::RawImage>("foxglove.RawImage", &[]);
    let unused = ["points", "metadata", "circles.metadata", "texts.metadata"];
    agrees::<foxglove::ImageAnnotations>("foxglove.ImageAnnotations", &unused);
    agrees::<foxglove::PoseInFrame>("foxglove.PoseInFrame", &[]);
    agrees::<foxglove::FrameTransform>("foxglove.FrameTransform", &[]);
    agrees::<foxglove::JointStates>("foxglove.JointStates", &[]);
    agrees::<foxglove::Log>("foxglove.Log", &["file", "line"]);
    agrees::<tetrad::Configuration>("tetrad.Configuration", &[]);
    agrees::<tetrad::Taught>("tetrad.Taught", &[]);
    agrees::<tetrad::HandBegins>("tetrad.HandBegins", &[]);
    agrees::<tetrad::Observations>("tetrad.Observations", &[]);
    agrees::<tetrad::Hand>("tetrad.Hand", &[]);
    agrees::<tetrad::Instant>("tetrad.Instant", &[]);
    agrees::<tetrad::Command>("tetrad.Command", &[]);
    agrees::<tetrad::Buttons>("tetrad.Buttons", &[]);
    agrees::<tetrad::Arm>("tetrad.Arm", &[]);
    agrees::<tetrad::Delays>("tetrad.Delays", &[]);
}

#[test]
fn every_topic_has_a_schema() {
    let pool = DescriptorPool::decode(DESCRIPTORS).unwrap();
    for topic in crate::session::Topic::all(1) {
        assert!(pool.get_message_by_name(topic.schema()).is_some(), "{topic:?}: {}", topic.schema());
    }
}
