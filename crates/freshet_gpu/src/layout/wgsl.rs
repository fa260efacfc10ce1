//! Rust types that have the same bytes in WGSL, and the macro that declares a struct for both.

use bytemuck::{Pod, Zeroable};

/// A type with the same bytes in Rust and in WGSL.
pub trait WgslType {
    /// Its alignment in WGSL.
    const ALIGN: usize;

    /// Its name in WGSL.
    fn wgsl() -> String;
}

/// A `u32` that shaders change atomically.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub struct Atomic(pub u32);

macro_rules! wgsl_types {
    ($($rust:ty = $align:literal $name:literal),* $(,)?) => {
        $(impl WgslType for $rust {
            const ALIGN: usize = $align;

            fn wgsl() -> String {
                $name.to_owned()
            }
        })*
    };
}

wgsl_types! {
    f32 = 4 "f32",
    u32 = 4 "u32",
    Atomic = 4 "atomic<u32>",
    [u32; 2] = 8 "vec2<u32>",
    [f32; 4] = 16 "vec4<f32>",
    glam::Vec3 = 16 "vec3<f32>",
    glam::UVec3 = 16 "vec3<u32>",
}

impl<T: WgslStruct> WgslType for [T; 4] {
    const ALIGN: usize = T::STRUCT_ALIGN;

    fn wgsl() -> String {
        format!("array<{}, 4>", T::NAME)
    }
}

/// One member of a struct.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its name.
    pub name: &'static str,
    /// Its type in WGSL.
    pub wgsl: String,
    /// Its alignment in WGSL.
    pub align: usize,
    /// Where it is in Rust.
    pub offset: usize,
    /// Its size in Rust.
    pub size: usize,
}

/// A struct declared for both languages at once.
pub trait WgslStruct: Pod {
    /// Its name, the same in both languages.
    const NAME: &'static str;
    /// Its alignment in WGSL.
    const STRUCT_ALIGN: usize;

    /// Its members, in order.
    fn members() -> Vec<Member>;

    /// Its declaration in WGSL.
    fn declaration() -> String {
        let members: String =
            Self::members().iter().map(|member| format!("    {}: {},\n", member.name, member.wgsl)).collect();
        format!("struct {} {{\n{members}}}\n", Self::NAME)
    }
}

/// Declares a struct whose members lie at the same offsets in Rust and WGSL; a test compares them. Gaps that WGSL's
/// alignment leaves are members of their own, as `Pod` allows no padding.
macro_rules! wgsl_struct {
    ($($(#[$doc:meta])* pub struct $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty),* $(,)? })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
            #[repr(C)]
            pub struct $name {
                $($(#[$field_doc])* pub $field: $type,)*
            }

            impl $crate::layout::WgslStruct for $name {
                const NAME: &'static str = stringify!($name);
                const STRUCT_ALIGN: usize = {
                    let mut align = 4;
                    $(if <$type as $crate::layout::WgslType>::ALIGN > align {
                        align = <$type as $crate::layout::WgslType>::ALIGN;
                    })*
                    align
                };

                fn members() -> Vec<$crate::layout::wgsl::Member> {
                    vec![$($crate::layout::wgsl::Member {
                        name: stringify!($field),
                        wgsl: <$type as $crate::layout::WgslType>::wgsl(),
                        align: <$type as $crate::layout::WgslType>::ALIGN,
                        offset: std::mem::offset_of!($name, $field),
                        size: size_of::<$type>(),
                    }),*]
                }
            }
        )*

        /// The declarations of all these structs, in WGSL.
        pub(crate) fn declarations() -> String {
            [$(<$name as $crate::layout::WgslStruct>::declaration()),*].concat()
        }

        #[cfg(test)]
        mod layout_tests {
            use super::*;
            use crate::layout::WgslStruct;

            #[test]
            fn members_lie_where_wgsl_puts_them() {
                $({
                    let mut end = 0usize;
                    for member in $name::members() {
                        let wanted = end.next_multiple_of(member.align);
                        assert_eq!(member.offset, wanted, "{}.{}", $name::NAME, member.name);
                        end = wanted + member.size;
                    }
                    assert_eq!(size_of::<$name>(), end.next_multiple_of($name::STRUCT_ALIGN), "{}", $name::NAME);
                })*
            }
        }
    };
}

pub(crate) use wgsl_struct;
