//! The kernel's structures (linux/videodev2.h) as they lie in memory on 64-bit x86 and Arm, and the
//! numbers of the calls that take them.
//!
//! Unions are written as the one member that is used, followed by bytes up to the union's size.
//! The sizes are checked at compile time, the offsets and numbers by the tests below.

use std::marker::PhantomData;

/// `V4L2_BUF_TYPE_VIDEO_CAPTURE`.
pub(super) const CAPTURE: u32 = 1;
/// `V4L2_MEMORY_MMAP`.
pub(super) const MEMORY_MMAP: u32 = 1;

/// An ioctl number together with the structure it takes.
pub(super) struct Request<T> {
    pub(super) number: u32,
    takes: PhantomData<fn(&mut T)>,
}

impl<T> Request<T> {
    const WRITE: u32 = 1;
    const READ: u32 = 2;

    /// `_IOC(direction, 'V', number, sizeof(T))`.
    const fn new(direction: u32, number: u32) -> Self {
        let size = size_of::<T>() as u32;
        Self { number: direction << 30 | size << 16 | (b'V' as u32) << 8 | number, takes: PhantomData }
    }
}

pub(super) const QUERYCAP: Request<Capability> = Request::new(Request::<()>::READ, 0);
pub(super) const ENUM_FMT: Request<FormatDescription> = Request::new(RW, 2);
pub(super) const S_FMT: Request<Format> = Request::new(RW, 5);
pub(super) const REQBUFS: Request<RequestBuffers> = Request::new(RW, 8);
pub(super) const QUERYBUF: Request<Buffer> = Request::new(RW, 9);
pub(super) const QBUF: Request<Buffer> = Request::new(RW, 15);
pub(super) const DQBUF: Request<Buffer> = Request::new(RW, 17);
pub(super) const STREAMON: Request<i32> = Request::new(Request::<()>::WRITE, 18);
pub(super) const STREAMOFF: Request<i32> = Request::new(Request::<()>::WRITE, 19);
pub(super) const S_PARM: Request<StreamParameters> = Request::new(RW, 22);
pub(super) const G_CTRL: Request<Control> = Request::new(RW, 27);
pub(super) const S_CTRL: Request<Control> = Request::new(RW, 28);
pub(super) const QUERYCTRL: Request<QueryControl> = Request::new(RW, 36);
pub(super) const TRY_FMT: Request<Format> = Request::new(RW, 64);
pub(super) const ENUM_FRAMESIZES: Request<FrameSizeEnum> = Request::new(RW, 74);

const RW: u32 = Request::<()>::READ | Request::<()>::WRITE;

/// `struct v4l2_capability`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct Capability {
    pub(super) driver: [u8; 16],
    pub(super) card: [u8; 32],
    pub(super) bus_info: [u8; 32],
    pub(super) version: u32,
    pub(super) capabilities: u32,
    pub(super) device_caps: u32,
    pub(super) reserved: [u32; 3],
}

/// `struct v4l2_fmtdesc`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct FormatDescription {
    pub(super) index: u32,
    pub(super) kind: u32,
    pub(super) flags: u32,
    pub(super) description: [u8; 32],
    pub(super) fourcc: [u8; 4],
    pub(super) mbus_code: u32,
    pub(super) reserved: [u32; 3],
}

/// `struct v4l2_frmsizeenum`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct FrameSizeEnum {
    pub(super) index: u32,
    pub(super) fourcc: [u8; 4],
    /// 1: one size, width and height; 2 and 3: a range.
    pub(super) kind: u32,
    /// Width and height, or least, greatest and step of the width, then of the height.
    pub(super) values: [u32; 6],
    pub(super) reserved: [u32; 2],
}

/// `struct v4l2_pix_format`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct PixFormat {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) fourcc: [u8; 4],
    pub(super) field: u32,
    pub(super) bytesperline: u32,
    pub(super) sizeimage: u32,
    pub(super) colorspace: u32,
    pub(super) private: u32,
    pub(super) flags: u32,
    pub(super) ycbcr_enc: u32,
    pub(super) quantization: u32,
    pub(super) xfer_func: u32,
}

/// `struct v4l2_format`
#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct Format {
    pub(super) kind: u32,
    pub(super) padding: u32,
    pub(super) pix: PixFormat,
    pub(super) rest: [u8; 152],
}

impl Format {
    pub(super) fn capture(pix: PixFormat) -> Self {
        Self { kind: CAPTURE, padding: 0, pix, rest: [0; 152] }
    }
}

/// `struct v4l2_streamparm` with `struct v4l2_captureparm`
#[repr(C)]
#[derive(Clone, Copy)]
pub(super) struct StreamParameters {
    pub(super) kind: u32,
    pub(super) capability: u32,
    pub(super) capturemode: u32,
    /// Seconds a frame, as a fraction.
    pub(super) numerator: u32,
    pub(super) denominator: u32,
    pub(super) rest: [u8; 184],
}

impl StreamParameters {
    pub(super) fn interval(numerator: u32, denominator: u32) -> Self {
        Self { kind: CAPTURE, capability: 0, capturemode: 0, numerator, denominator, rest: [0; 184] }
    }
}

/// `struct v4l2_requestbuffers`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct RequestBuffers {
    pub(super) count: u32,
    pub(super) kind: u32,
    pub(super) memory: u32,
    pub(super) capabilities: u32,
    pub(super) flags: u8,
    pub(super) reserved: [u8; 3],
}

/// `struct v4l2_buffer`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct Buffer {
    pub(super) index: u32,
    pub(super) kind: u32,
    pub(super) bytesused: u32,
    pub(super) flags: u32,
    pub(super) field: u32,
    pub(super) padding: u32,
    pub(super) seconds: i64,
    pub(super) microseconds: i64,
    pub(super) timecode: [u32; 4],
    pub(super) sequence: u32,
    pub(super) memory: u32,
    /// The first half is the offset to map.
    pub(super) offset: [u32; 2],
    pub(super) length: u32,
    pub(super) reserved: u32,
    pub(super) request_fd: i32,
    pub(super) tail: u32,
}

/// `struct v4l2_queryctrl`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct QueryControl {
    pub(super) id: u32,
    pub(super) kind: u32,
    pub(super) name: [u8; 32],
    pub(super) minimum: i32,
    pub(super) maximum: i32,
    pub(super) step: i32,
    pub(super) default: i32,
    pub(super) flags: u32,
    pub(super) reserved: [u32; 2],
}

/// `struct v4l2_control`
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct Control {
    pub(super) id: u32,
    pub(super) value: i32,
}

const _: () = {
    assert!(size_of::<Capability>() == 104);
    assert!(size_of::<FormatDescription>() == 64);
    assert!(size_of::<FrameSizeEnum>() == 44);
    assert!(size_of::<PixFormat>() == 48);
    assert!(size_of::<Format>() == 208);
    assert!(size_of::<StreamParameters>() == 204);
    assert!(size_of::<RequestBuffers>() == 20);
    assert!(size_of::<Buffer>() == 88);
    assert!(size_of::<QueryControl>() == 68);
    assert!(size_of::<Control>() == 8);
};

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;

    #[test]
    fn fields_lie_where_the_kernel_looks_for_them() {
        assert_eq!(offset_of!(Capability, device_caps), 88);
        assert_eq!(offset_of!(FormatDescription, fourcc), 44);
        assert_eq!(offset_of!(Format, pix), 8);
        assert_eq!(offset_of!(PixFormat, quantization), 40);
        assert_eq!(offset_of!(StreamParameters, numerator), 12);
        assert_eq!(offset_of!(Buffer, seconds), 24);
        assert_eq!(offset_of!(Buffer, sequence), 56);
        assert_eq!(offset_of!(Buffer, offset), 64);
        assert_eq!(offset_of!(Buffer, length), 72);
        assert_eq!(offset_of!(QueryControl, flags), 56);
    }

    #[test]
    fn calls_have_the_numbers_of_the_kernel_header() {
        // As printed by a C program that includes linux/videodev2.h.
        for (number, expected) in [
            (QUERYCAP.number, 0x8068_5600),
            (ENUM_FMT.number, 0xc040_5602),
            (S_FMT.number, 0xc0d0_5605),
            (REQBUFS.number, 0xc014_5608),
            (QUERYBUF.number, 0xc058_5609),
            (QBUF.number, 0xc058_560f),
            (DQBUF.number, 0xc058_5611),
            (STREAMON.number, 0x4004_5612),
            (STREAMOFF.number, 0x4004_5613),
            (S_PARM.number, 0xc0cc_5616),
            (G_CTRL.number, 0xc008_561b),
            (S_CTRL.number, 0xc008_561c),
            (QUERYCTRL.number, 0xc044_5624),
            (TRY_FMT.number, 0xc0d0_5640),
            (ENUM_FRAMESIZES.number, 0xc02c_564a),
        ] {
            assert_eq!(number, expected, "{number:#x}");
        }
    }
}
