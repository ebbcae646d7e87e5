//! Pixels as places in a palette: a byte each, which makes PNG files smaller and their making faster.

use std::collections::HashMap;

/// A palette has places for as many colours.
const PLACES: usize = 256;
/// A picture of more colours is no chart.
const MOST: usize = 1 << 13;
/// So many of them are for the most frequent colours, if there are more than places.
const FREQUENT: usize = 160;
/// The square of how far a colour may lie from its place.
const NEAR: u32 = 32 * 32;

/// A picture of few colours.
pub(crate) struct Indexed {
    /// Red, green and blue of one colour after the other.
    pub(crate) palette: Vec<u8>,
    /// Neighbouring pixels of one colour, row by row: its place in the palette, and how many they are.
    runs: Vec<(u16, u32)>,
}

/// Red, green, blue and opacity of a pixel.
type Pixel = [u8; 4];

impl Indexed {
    /// The pixels of a picture; nothing if it is transparent somewhere, or has more colours than a palette can stand for.
    ///
    /// Edges of curves that cross have hundreds of colours, each of a few pixels. Of more than 256 colours the most frequent ones are
    /// kept, then those that are farthest from all kept ones; the others become the nearest of these.
    pub(crate) fn of(pixels: &[Pixel]) -> Option<Self> {
        let (runs, colors) = runs(pixels)?;
        let mut order: Vec<usize> = (0..colors.len()).collect();
        // Of equally frequent ones the first comes first.
        order.sort_by_key(|&color| std::cmp::Reverse(colors[color].1));
        let frequent = if order.len() > PLACES { FREQUENT } else { order.len() };
        let mut palette = Vec::with_capacity(3 * PLACES);
        // For each colour the nearest place so far, and how far it is.
        let mut nearest = vec![(u32::MAX, 0_u16); colors.len()];
        for place in 0..u16::try_from(order.len().min(PLACES)).ok()? {
            let farthest = || (0..colors.len()).max_by_key(|&color| nearest[color].0);
            let kept = if usize::from(place) < frequent { order[usize::from(place)] } else { farthest()? };
            let kept = colors[kept].0;
            palette.extend(kept);
            for (near, (color, _)) in nearest.iter_mut().zip(&colors) {
                *near = (*near).min((distance(*color, kept), place));
            }
        }
        if nearest.iter().any(|(distance, _)| *distance > NEAR) {
            return None;
        }
        let runs = runs.into_iter().map(|(color, length)| (nearest[usize::from(color)].1, length)).collect();
        Some(Self { palette, runs })
    }

    /// Runs of pixels: their place in the palette, and how many they are.
    #[allow(clippy::cast_possible_truncation)] // a palette has 256 places
    pub(crate) fn runs(&self) -> impl Iterator<Item = (u8, usize)> {
        self.runs.iter().map(|(place, length)| (*place as u8, *length as usize))
    }
}

/// Runs of pixels of one colour, and all colours with the number of their pixels.
#[allow(clippy::type_complexity)] // two lists, each used once
fn runs(pixels: &[Pixel]) -> Option<(Vec<(u16, u32)>, Vec<([u8; 3], u64)>)> {
    let mut runs = Vec::new();
    let mut colors: Vec<([u8; 3], u64)> = Vec::new();
    let mut known: HashMap<Pixel, u16> = HashMap::new();
    // Where a colour was found last: most colours come again soon.
    let mut recent = [([0; 4], 0_u16); 1 << 8];
    let mut rest = pixels;
    while let Some(&pixel) = rest.first() {
        let word = u32::from_ne_bytes(pixel);
        let length = run(rest, word);
        rest = &rest[length..];
        let [red, green, blue, opacity] = pixel;
        if opacity != u8::MAX {
            return None;
        }
        let slot = &mut recent[usize::from(red.wrapping_mul(31) ^ green.wrapping_mul(7) ^ blue)];
        if slot.0 != pixel {
            let color = *known.entry(pixel).or_insert_with(|| {
                colors.push(([red, green, blue], 0));
                u16::try_from(colors.len() - 1).unwrap_or(u16::MAX)
            });
            if colors.len() > MOST {
                return None;
            }
            *slot = (pixel, color);
        }
        colors[usize::from(slot.1)].1 += length as u64;
        runs.push((slot.1, u32::try_from(length).ok()?));
    }
    Some((runs, colors))
}

/// How many pixels at the beginning are this one.
fn run(pixels: &[Pixel], word: u32) -> usize {
    const FEW: usize = 4;
    const TOGETHER: usize = 16;
    let is_other = |pixel: &Pixel| u32::from_ne_bytes(*pixel) != word;
    // Most runs end at once; those that do not are long, and many pixels are looked at together.
    if let Some(length) = pixels.iter().take(FEW).position(is_other) {
        return length;
    }
    let (groups, _) = pixels.as_chunks::<TOGETHER>();
    let differ =
        |group: &[Pixel; TOGETHER]| group.iter().fold(0, |all, pixel| all | (u32::from_ne_bytes(*pixel) ^ word));
    let alike = TOGETHER * groups.iter().position(|group| differ(group) != 0).unwrap_or(groups.len());
    let rest = &pixels[alike..];
    alike + rest.iter().position(is_other).unwrap_or(rest.len())
}

/// The square of the distance of two colours.
fn distance(one: [u8; 3], other: [u8; 3]) -> u32 {
    (0..3).map(|part| u32::from(one[part].abs_diff(other[part])).pow(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(indexed: &Indexed) -> Vec<[u8; 3]> {
        let color = |place: u8| std::array::from_fn(|part| indexed.palette[3 * usize::from(place) + part]);
        indexed.runs().flat_map(|(place, length)| vec![color(place); length]).collect()
    }

    /// Pixels of these colours.
    fn picture(count: u32, color: impl Fn(u32) -> [u32; 3]) -> Vec<Pixel> {
        let pixel = |index| {
            let [red, green, blue] = color(index).map(|part| u8::try_from(part).unwrap());
            [red, green, blue, 255]
        };
        (0..count).map(pixel).collect()
    }

    #[test]
    fn few_colours_stay_as_they_are() {
        let picture = picture(100_000, |index| [index / 777, 7, 9]);
        let indexed = Indexed::of(&picture).unwrap();
        assert_eq!(indexed.palette.len(), 3 * 129);
        assert!(pixels(&indexed).iter().zip(&picture).all(|(color, pixel)| color[..] == pixel[..3]));
    }

    #[test]
    fn rare_colours_become_frequent_ones_beside_them() {
        // A ramp of 128 colours, and once each 500 others that are up to ten levels greener.
        let picture = picture(90_000, |index| [index % 128, if index < 500 { 1 + index / 50 } else { 0 }, 0]);
        let indexed = Indexed::of(&picture).unwrap();
        assert_eq!(indexed.palette.len(), 3 * 256);
        let shown = pixels(&indexed);
        let far =
            |(color, pixel): (&[u8; 3], &Pixel)| (0..3).map(|part| color[part].abs_diff(pixel[part])).max().unwrap();
        let far: Vec<u8> = shown.iter().zip(&picture).map(far).collect();
        assert!(far[500..].iter().all(|far| *far == 0), "the frequent ones are kept");
        assert!(far[..500].iter().all(|far| *far <= 3), "128 places are left for ten rows of 50");
        assert_eq!(far[..500].iter().filter(|far| **far > 0).count(), 500 - 128);
    }

    #[test]
    fn what_is_no_chart_has_no_palette() {
        assert!(Indexed::of(&[[1, 2, 3, 255], [0, 0, 0, 0]]).is_none(), "transparent");
        assert!(Indexed::of(&picture(4096, |x| [1, 16, 256].map(|step| x / step % 16 * 17))).is_none(), "all over");
        assert!(Indexed::of(&picture(10_000, |x| [x % 100, x / 100, 0])).is_none(), "very many of them");
    }
}
