//! What the drive page asks of the console, asked without drawing it: both sockets read, each picture
//! thanked for. It stands for a page at another computer.

use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::thread::JoinHandle;

/// A camera's preview is longer by far than this on no computer.
const MOST: u64 = 16 << 20;

const TEXT: u8 = 1;
const BINARY: u8 = 2;

/// A page that is read. Dropped, it is closed.
pub(super) struct PageReader {
    lines: Vec<(TcpStream, JoinHandle<io::Result<()>>)>,
}

impl PageReader {
    /// Opens `/live`, and `/pictures` of the first views.
    ///
    /// # Errors
    /// The console does not answer, or refuses.
    pub(super) fn open(console: &str, views: usize) -> io::Result<Self> {
        let views: Vec<String> = (0..views).map(|view| view.to_string()).collect();
        let paths = ["/live".to_owned(), format!("/pictures?views={}", views.join(","))];
        let lines = paths.iter().map(|path| {
            let stream = upgrade(console, path)?;
            let reading = stream.try_clone()?;
            Ok((stream, std::thread::spawn(move || read(reading))))
        });
        Ok(Self { lines: lines.collect::<io::Result<_>>()? })
    }
}

impl Drop for PageReader {
    fn drop(&mut self) {
        for (stream, thread) in self.lines.drain(..) {
            // the console may have ended it
            let _ = stream.shutdown(Shutdown::Both);
            let _ = thread.join();
        }
    }
}

/// A WebSocket (RFC 6455, section 4.1).
fn upgrade(console: &str, path: &str) -> io::Result<TcpStream> {
    let mut stream = TcpStream::connect(console)?;
    stream.set_nodelay(true)?;
    write!(
        stream,
        "GET {path} HTTP/1.1\r\nHost: {console}\r\nOrigin: http://{console}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )?;
    // byte by byte: what follows the head is the first message
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte)?;
        head.extend(byte);
    }
    if head.starts_with(b"HTTP/1.1 101") {
        Ok(stream)
    } else {
        Err(io::Error::other(format!("{path}: {}", String::from_utf8_lossy(&head))))
    }
}

/// Reads messages until the end, and thanks for pictures.
fn read(stream: TcpStream) -> io::Result<()> {
    let mut answering = stream.try_clone()?;
    let mut stream = BufReader::new(stream);
    while !stream.fill_buf()?.is_empty() {
        let (kind, message) = message(&mut stream)?;
        if kind == BINARY {
            answering.write_all(&thanks(&message))?;
        }
    }
    Ok(())
}

/// A frame without a mask, as servers send them (section 5.2).
fn message(stream: &mut BufReader<TcpStream>) -> io::Result<(u8, Vec<u8>)> {
    let mut start = [0; 2];
    stream.read_exact(&mut start)?;
    let [first, length] = start;
    let mut long = [0; 8];
    let length = match length {
        126 => {
            stream.read_exact(&mut long[6..])?;
            u64::from_be_bytes(long)
        }
        127 => {
            stream.read_exact(&mut long)?;
            u64::from_be_bytes(long)
        }
        short => short.into(),
    };
    if length > MOST {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut message = vec![0; length as usize];
    stream.read_exact(&mut message)?;
    Ok((first & 0x0f, message))
}

/// That a picture was shown: a text with a mask of nothing.
fn thanks(picture: &[u8]) -> Vec<u8> {
    let header = picture.iter().skip(4).take_while(|byte| **byte != b'}').copied().collect::<Vec<u8>>();
    let header = String::from_utf8_lossy(&header);
    let view = header.split_once("\"view\":").and_then(|(_, rest)| rest.split([',', '}']).next());
    let text = format!("{{\"type\":\"shown\",\"view\":{}}}", view.unwrap_or("0"));
    let mut frame = vec![0x80 | TEXT, 0x80 | text.len() as u8, 0, 0, 0, 0];
    frame.extend(text.as_bytes());
    frame
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_view_of_a_picture_is_thanked_for() {
        let told = thanks(b"\x10\0\0\0{\"view\":1,\"sequence\":7,\"balls\":[{}]}\xff\xd8");
        assert_eq!(told, b"\x81\x99\0\0\0\0{\"type\":\"shown\",\"view\":1}");
    }
}
