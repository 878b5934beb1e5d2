//! What a search says of itself where it finds nothing.

use super::room::room;
use serde_json::{Value, json};

/// Each camera's balls, and what the search said there.
fn balls(told: &Value) -> impl Iterator<Item = &Value> {
    told["cameras"].as_array().unwrap().iter().take(2).flat_map(|camera| camera["balls"].as_array().unwrap())
}

#[tokio::test]
async fn a_search_that_fails_after_one_that_found_says_so() {
    let room = room();
    let find = async || room.done("/api/setup/find", json!({"page": 1})).await;
    let found = find().await;
    assert_eq!(found["said"], "the four balls were found by 2 of 2 cameras");

    room.cover(true);
    let covered = find().await;
    assert_eq!(covered["said"], "the four balls were found by 0 of 2 cameras");
    for camera in [&covered["cameras"][0], &covered["cameras"][1]] {
        assert_eq!(camera["failed"], true, "{camera}");
        assert!(camera["said"].as_str().unwrap().starts_with("no ball found of colour "), "{camera}");
    }
    // what was learnt stays, and is looked for in the new picture
    for (ball, before) in balls(&covered).zip(balls(&found)) {
        assert_eq!((&ball["reference"], &ball["diameter"]), (&before["reference"], &before["diameter"]));
        assert_eq!(ball["found"], Value::Null, "{ball}");
        assert!(ball["clash"].as_str().unwrap().starts_with("NOT FOUND in this picture"), "{ball}");
    }
    assert_eq!((balls(&found).count(), balls(&covered).count()), (8, 8));

    room.cover(false);
    let again = find().await;
    assert_eq!(again["said"], found["said"]);
    assert!((0..2).all(|camera| again["cameras"][camera]["failed"] == false), "{again}");
    assert!(balls(&again).all(|ball| ball["found"].is_object()), "{again}");

    // one that has failed says so until something else is shown
    room.cover(true);
    assert_eq!(find().await["cameras"][0]["failed"], true);
    let still = room.done("/api/setup/still", json!({"page": 1})).await;
    assert_eq!((&still["cameras"][0]["failed"], &still["cameras"][0]["said"]), (&json!(false), &json!("")));
}
