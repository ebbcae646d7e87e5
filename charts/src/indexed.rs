//! Pixels as places in a palette: a byte each, which makes PNG files smaller and their making faster.

use std::collections::HashMap;

use crate::picture::Color;

/// A palette has places for as many colours.
const PLACES: usize = 256;
/// A picture of more colours is no chart.
pub(crate) const MOST: usize = 1 << 13;
/// So many of them are for the most frequent colours, if there are more than places.
const FREQUENT: usize = 160;
/// The square of how far a colour may lie from its place.
const NEAR: f32 = 32.0 * 32.0;
/// So many pixels are looked at together: most are alike.
const TOGETHER: usize = 16;

/// A picture of few colours.
pub(crate) struct Indexed {
    /// Red, green and blue of one colour after the other.
    pub(crate) palette: Vec<u8>,
    /// The rows as PNG has them: a zero, then the place of each pixel in the palette.
    pub(crate) rows: Vec<u8>,
}

impl Indexed {
    /// A picture with so many pixels in a row, each the place of its colour; nothing if it has more colours than a palette can stand
    /// for. The rows are written to memory that may have been used before.
    ///
    /// Edges of curves that cross have hundreds of colours, each of a few pixels. Of more than 256 colours the most frequent ones are
    /// kept, then those that are farthest from all kept ones; the others become the nearest of these.
    pub(crate) fn of(columns: usize, pixels: &[u16], colors: &[Color], mut rows: Vec<u8>) -> Option<Self> {
        rows.clear();
        let length = pixels.len() + pixels.len() / columns.max(1);
        if rows.capacity() < length {
            // To make it longer would copy what is in it.
            rows = Vec::new();
            rows.try_reserve_exact(length).ok()?;
        }
        let distinct = distinct(columns, pixels);
        if colors.len() <= PLACES {
            #[allow(clippy::cast_possible_truncation)] // fewer than 256
            write(&mut rows, &distinct, |to, row| to.iter_mut().zip(row).for_each(|(to, place)| *to = *place as u8));
            return Some(Self { palette: colors.concat(), rows });
        }
        let (palette, places) = reduced(&counted(&distinct, colors))?;
        write(&mut rows, &distinct, |to, row| {
            let (groups, rest) = row.as_chunks::<TOGETHER>();
            let (of_groups, of_rest) = to.as_chunks_mut::<TOGETHER>();
            let place = |(to, color): (&mut u8, &u16)| *to = places[usize::from(*color)];
            for (to, group) in of_groups.iter_mut().zip(groups) {
                if are_alike(group) {
                    *to = [places[usize::from(group[0])]; TOGETHER];
                } else {
                    to.iter_mut().zip(group).for_each(place);
                }
            }
            of_rest.iter_mut().zip(rest).for_each(place);
        });
        Some(Self { palette, rows })
    }

    /// The same of a picture of red, green, blue and opacity; nothing also if it is transparent somewhere.
    pub(crate) fn of_pixels(columns: usize, pixels: &[[u8; 4]]) -> Option<Self> {
        let mut colors: Vec<Color> = Vec::new();
        let mut known: HashMap<[u8; 4], u16> = HashMap::new();
        let mut last = None;
        let mut place = |pixel: [u8; 4]| {
            let [red, green, blue, opacity] = pixel;
            let place = *known.entry(pixel).or_insert_with(|| {
                colors.push([red, green, blue]);
                u16::try_from(colors.len() - 1).unwrap_or(u16::MAX)
            });
            (opacity == u8::MAX && usize::from(place) < MOST).then_some(place)
        };
        let places = pixels.iter().map(|pixel| match last {
            Some((same, place)) if same == *pixel => Some(place),
            _ => {
                let place = place(*pixel)?;
                last = Some((*pixel, place));
                Some(place)
            }
        });
        let places: Vec<u16> = places.collect::<Option<_>>()?;
        Self::of(columns, &places, &colors, Vec::new())
    }
}

/// The rows, and how many after each are equal to it, itself among them.
fn distinct(columns: usize, pixels: &[u16]) -> Vec<(&[u16], u32)> {
    let mut distinct: Vec<(&[u16], u32)> = Vec::new();
    for row in pixels.chunks(columns.max(1)) {
        match distinct.last_mut() {
            Some((last, count)) if *last == row => *count += 1,
            _ => distinct.push((row, 1)),
        }
    }
    distinct
}

/// Writes rows, each after a zero.
fn write(rows: &mut Vec<u8>, distinct: &[(&[u16], u32)], write: impl Fn(&mut [u8], &[u16])) {
    for (row, count) in distinct {
        let begin = rows.len();
        let end = begin + 1 + row.len();
        rows.resize(end, 0);
        write(&mut rows[begin + 1..], row);
        for _ in 1..*count {
            rows.extend_from_within(begin..end);
        }
    }
}

/// The colours, and how many pixels have them.
fn counted(distinct: &[(&[u16], u32)], colors: &[Color]) -> Vec<(Color, u32)> {
    let mut counted: Vec<(Color, u32)> = colors.iter().map(|color| (*color, 0)).collect();
    for (row, times) in distinct {
        let (groups, rest) = row.as_chunks::<TOGETHER>();
        let mut count = |color: u16, pixels: u32| counted[usize::from(color)].1 += times * pixels;
        for group in groups {
            if are_alike(group) {
                count(group[0], 16);
            } else {
                for color in group {
                    count(*color, 1);
                }
            }
        }
        for color in rest {
            count(*color, 1);
        }
    }
    counted
}

fn are_alike(group: &[u16; TOGETHER]) -> bool {
    *group == [group[0]; TOGETHER]
}

/// A palette of 256 colours, and the place in it of each of these.
fn reduced(colors: &[(Color, u32)]) -> Option<(Vec<u8>, Vec<u8>)> {
    let mut order: Vec<usize> = (0..colors.len()).collect();
    // Of equally frequent ones the first comes first.
    order.sort_by_key(|&color| std::cmp::Reverse(colors[color].1));
    let mut palette = Vec::with_capacity(3 * PLACES);
    // Side by side, so that several are looked at together; whole numbers up to 2²⁴ are exact.
    let parts: [Vec<f32>; 3] =
        std::array::from_fn(|part| colors.iter().map(|(color, _)| f32::from(color[part])).collect());
    // For each colour the nearest place so far, and how far it is.
    let (mut nearest, mut distances) = (vec![0_u32; colors.len()], vec![f32::INFINITY; colors.len()]);
    for place in 0..=u8::MAX {
        let kept = if usize::from(place) < FREQUENT { order[usize::from(place)] } else { farthest(&distances)? };
        palette.extend(colors[kept].0);
        let [red, green, blue] = colors[kept].0.map(f32::from);
        let [reds, greens, blues] = [&parts[0], &parts[1], &parts[2]];
        let near = nearest.iter_mut().zip(&mut distances);
        for (((near, shortest), red_here), (green_here, blue_here)) in near.zip(reds).zip(greens.iter().zip(blues)) {
            let [red, green, blue] = [red_here - red, green_here - green, blue_here - blue];
            let distance = red * red + green * green + blue * blue;
            *near = if distance < *shortest { u32::from(place) } else { *near };
            *shortest = if distance < *shortest { distance } else { *shortest };
        }
    }
    #[allow(clippy::cast_possible_truncation)] // places are below 256
    let places = || nearest.iter().map(|place| *place as u8).collect();
    distances.iter().all(|distance| *distance <= NEAR).then(|| (palette, places()))
}

/// Where the largest of these numbers is; the last of equal ones.
fn farthest(distances: &[f32]) -> Option<usize> {
    // Side by side, so that one comparison needs not wait for the one before.
    const LANES: usize = 8;
    let (groups, rest) = distances.as_chunks::<LANES>();
    let mut largest = [0.0_f32; LANES];
    for group in groups {
        for (largest, distance) in largest.iter_mut().zip(group) {
            *largest = if distance > largest { *distance } else { *largest };
        }
    }
    let largest = largest.iter().chain(rest).copied().fold(0.0, f32::max);
    distances.iter().rposition(|distance| *distance == largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(indexed: &Indexed) -> Vec<[u8; 3]> {
        let color = |place: u8| std::array::from_fn(|part| indexed.palette[3 * usize::from(place) + part]);
        let rows = indexed.rows.chunks(COLUMNS + 1);
        rows.flat_map(|row| row[1..].iter().map(|place| color(*place)).collect::<Vec<_>>()).collect()
    }

    const COLUMNS: usize = 500;

    /// Pixels of these colours.
    fn picture(count: u32, color: impl Fn(u32) -> [u32; 3]) -> Vec<[u8; 4]> {
        let pixel = |index| {
            let [red, green, blue] = color(index).map(|part| u8::try_from(part).unwrap());
            [red, green, blue, 255]
        };
        (0..count).map(pixel).collect()
    }

    #[test]
    fn few_colours_stay_as_they_are() {
        let picture = picture(100_000, |index| [index / 777, 7, 9]);
        let indexed = Indexed::of_pixels(COLUMNS, &picture).unwrap();
        assert_eq!(indexed.palette.len(), 3 * 129);
        assert!(pixels(&indexed).iter().zip(&picture).all(|(color, pixel)| color[..] == pixel[..3]));
    }

    #[test]
    fn rare_colours_become_frequent_ones_beside_them() {
        // A ramp of 128 colours, and once each 500 others that are up to ten levels greener.
        let picture = picture(90_000, |index| [index % 128, if index < 500 { 1 + index / 50 } else { 0 }, 0]);
        let indexed = Indexed::of_pixels(COLUMNS, &picture).unwrap();
        assert_eq!(indexed.palette.len(), 3 * 256);
        let shown = pixels(&indexed);
        let far =
            |(color, pixel): (&[u8; 3], &[u8; 4])| (0..3).map(|part| color[part].abs_diff(pixel[part])).max().unwrap();
        let far: Vec<u8> = shown.iter().zip(&picture).map(far).collect();
        assert!(far[500..].iter().all(|far| *far == 0), "the frequent ones are kept");
        assert!(far[..500].iter().all(|far| *far <= 3), "128 places are left for ten rows of 50");
        assert_eq!(far[..500].iter().filter(|far| **far > 0).count(), 500 - 128);
    }

    #[test]
    fn what_is_no_chart_has_no_palette() {
        assert!(Indexed::of_pixels(2, &[[1, 2, 3, 255], [0, 0, 0, 0]]).is_none(), "transparent");
        assert!(
            Indexed::of_pixels(COLUMNS, &picture(4096, |x| [1, 16, 256].map(|step| x / step % 16 * 17))).is_none(),
            "all over"
        );
        assert!(
            Indexed::of_pixels(COLUMNS, &picture(10_000, |x| [x % 100, x / 100, 0])).is_none(),
            "very many of them"
        );
    }
}
