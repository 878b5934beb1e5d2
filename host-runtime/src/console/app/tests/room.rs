//! Whether there is room for another page.

use super::*;

#[tokio::test]
async fn a_page_is_told_that_too_many_are_open() {
    let room = |sockets| {
        let state = State {
            desk: desk(),
            access: Arc::new(Access::loopback()),
            sessions: None,
            web_sockets: Arc::new(Semaphore::new(sockets)),
            within: WITHIN,
        };
        routes(state).oneshot(request(Method::GET, "/api/room", &[]))
    };
    assert_eq!(room(1).await.unwrap().status(), StatusCode::OK);
    let full = room(0).await.unwrap();
    assert_eq!(full.status(), StatusCode::SERVICE_UNAVAILABLE);
    assert_eq!(text(full).await, "too many pages are open: close one\n");
}
