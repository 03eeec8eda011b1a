//! Where a request aims: the age and gravitropism of its tree, and the law of roots there.

use crate::density::{Law, Place, Stock};
use crate::wish::{Wish, Wishes};
use crate::{GenerateError, Request};

/// How far the nearest root may be from what is asked for: five growth cycles, or a fifth of
/// gravitropism. Ages and values that no training tree had are drawn for from both sides.
const FURTHEST: f64 = 1.0;

/// How far from the mean of its species' own age a tree may be wished before its age is moved, and
/// from that of the age it is moved to, in standard deviations. Further out the networks follow a
/// wish less and less: willows wished 15 m high came out 17.9 m high at an age whose mean is a
/// deviation above, and 15.4 m where it is 0.3 above.
const EASE_AT_HOME: f64 = 1.5;
const EASE_AWAY: f64 = 0.3;

/// What the root of a request is drawn from.
#[derive(Clone, Debug)]
pub(crate) struct Aim {
    pub(crate) place: Place,
    pub(crate) law: Law,
}

/// Finds the law that a request is drawn from. A request that leaves the age open gets the
/// species' own or, where trees of that age are seldom as wished, the nearest age where many are; if
/// there is none such, the age where they are least seldom.
pub(crate) fn aim(stock: Stock<'_>, request: &Request) -> Result<Aim, GenerateError> {
    let field = Field::new(stock, request)?;
    let mut best: Option<(f64, Aim)> = None;
    for choice in field.choices() {
        if !request.wishes.made().all(|wish| choice.holds(&wish)) {
            continue;
        }
        let strain = choice.strain(&request.wishes);
        if strain <= if choice.asked { EASE_AT_HOME } else { EASE_AWAY } {
            return Ok(choice.aim);
        }
        if best.as_ref().is_none_or(|best| strain < best.0) {
            best = Some((strain, choice.aim));
        }
    }
    if let Some((_, aim)) = best {
        return Ok(aim);
    }
    for wish in request.wishes.made() {
        let (low, high) = field.range(&wish);
        if !(low..=high).contains(&wish.value) {
            return Err(GenerateError::OutOfRange {
                species: request.species.clone(),
                age: request.age.map(f32::from),
                what: wish.what,
                value: wish.value,
                low,
                high,
            });
        }
    }
    Err(GenerateError::NotTogether { species: request.species.clone() })
}

/// Checks what is asked for by itself: has the model seen such an age and gravitropism?
pub(crate) fn check(stock: Stock<'_>, request: &Request) -> Result<(), GenerateError> {
    Field::new(stock, request).map(drop)
}

/// The wishes moved to where [`aim`] can meet them.
pub(crate) fn clamp(stock: Stock<'_>, request: &Request) -> Result<Wishes, GenerateError> {
    let field = Field::new(stock, request)?;
    let clamped = |wish: Wish, (low, high): (f32, f32)| wish.value.clamp(low, high);
    let wishes = request.wishes.map(|wish| clamped(wish, field.range(&wish)));
    if aim(stock, &Request { wishes, ..request.clone() }).is_ok() {
        return Ok(wishes);
    }
    // Each is met at some age, all at none: they are moved to where the species is at home.
    let Some(own) = field.choices().next() else { return Ok(wishes) };
    Ok(wishes.map(|wish| clamped(wish, own.range(&wish))))
}

/// The roots as a request sees them.
struct Field<'a> {
    stock: Stock<'a>,
    /// What is asked for, with the species' own age or gravitropism where nothing is.
    place: Place,
    /// Ages that the tree may have instead, the nearest first.
    others: Vec<f32>,
}

/// A law that a request may be drawn from.
struct Choice {
    aim: Aim,
    /// Is it that of the place asked for?
    asked: bool,
}

impl Choice {
    /// What the wished number can be: at another age than asked for, only what was seen.
    fn range(&self, wish: &Wish) -> (f32, f32) {
        let law = &self.aim.law;
        let (low, high) = if self.asked { law.bounds(wish.index) } else { law.seen(wish.index) };
        (wish.told(low), wish.told(high))
    }

    /// How far the furthest wish is from the mean, in standard deviations.
    fn strain(&self, wishes: &Wishes) -> f64 {
        let strain = |wish: Wish| self.aim.law.strain(wish.index, wish.number());
        wishes.made().map(strain).fold(0.0, f64::max)
    }

    fn holds(&self, wish: &Wish) -> bool {
        let (low, high) = self.range(wish);
        (low..=high).contains(&wish.value)
    }
}

impl<'a> Field<'a> {
    /// Checks what is asked for by itself.
    fn new(stock: Stock<'a>, request: &Request) -> Result<Self, GenerateError> {
        let roots = stock.roots;
        let (youngest, oldest) = range(roots.iter().map(|root| root.age));
        let asked = request.age.map(f32::from);
        check_range(request, "age", asked, (youngest, oldest))?;
        let gravitropisms = rounded_out(range(roots.iter().map(|root| root.gravitropism)));
        check_range(request, "gravitropism", request.gravitropism, gravitropisms)?;
        if let Some(wish) = request.wishes.made().find(|wish| !wish.value.is_finite()) {
            return Err(GenerateError::NotFinite { what: wish.what, value: wish.value });
        }
        let own = Place::own(roots);
        let place = Place {
            age: asked.unwrap_or(own.age),
            gravitropism: request.gravitropism.unwrap_or(own.gravitropism),
        };
        let mut others = Vec::new();
        if asked.is_none() {
            others.extend((youngest as u16..=oldest as u16).map(f32::from));
            others.retain(|age| *age != place.age);
            others.sort_by(|a, b| (a - place.age).abs().total_cmp(&(b - place.age).abs()));
        }
        let field = Self { stock, place, others };
        let near = field.nearest(place);
        if place.distance(near) > FURTHEST {
            return Err(GenerateError::NotSeen {
                species: request.species.clone(),
                age: place.age,
                gravitropism: place.gravitropism,
                near_age: near.age,
                near_gravitropism: near.gravitropism,
            });
        }
        Ok(field)
    }

    /// The laws that the request may be drawn from, the best first.
    fn choices(&self) -> impl Iterator<Item = Choice> + '_ {
        let choice = |place, asked| {
            let law = Law::at(self.stock, place);
            Choice { aim: Aim { place, law }, asked }
        };
        let others = self.others.iter().map(|&age| Place { age, ..self.place });
        let others = others.filter(|&place| place.distance(self.nearest(place)) <= FURTHEST);
        std::iter::once(choice(self.place, true))
            .chain(others.map(move |place| choice(place, false)))
    }

    /// What the wished number can be at any of the ages.
    fn range(&self, wish: &Wish) -> (f32, f32) {
        range(self.choices().map(|choice| choice.range(wish)).flat_map(|(low, high)| [low, high]))
    }

    /// The place of the nearest root.
    fn nearest(&self, place: Place) -> Place {
        let places = self.stock.roots.iter().map(Place::of);
        let nearest = places.min_by(|a, b| place.distance(*a).total_cmp(&place.distance(*b)));
        nearest.unwrap_or(place)
    }
}

fn range(numbers: impl Iterator<Item = f32>) -> (f32, f32) {
    numbers.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// A range of numbers drawn from a continuum, which never hits its ends, out to full twentieths; a
/// single number stays what it is.
fn rounded_out((low, high): (f32, f32)) -> (f32, f32) {
    const STEPS: f32 = 20.0;
    if low < high {
        (libm::floorf(low * STEPS) / STEPS, libm::ceilf(high * STEPS) / STEPS)
    } else {
        (low, high)
    }
}

fn check_range(
    request: &Request,
    what: &'static str,
    value: Option<f32>,
    (low, high): (f32, f32),
) -> Result<(), GenerateError> {
    let Some(value) = value else { return Ok(()) };
    if !value.is_finite() {
        return Err(GenerateError::NotFinite { what, value });
    }
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let species = request.species.clone();
    Err(GenerateError::OutOfRange { species, age: None, what, value, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_draws_reach_their_round_ends() {
        assert_eq!(rounded_out((-0.3997, 0.3912)), (-0.4, 0.4));
        assert_eq!(rounded_out((-0.1, -0.1)), (-0.1, -0.1));
    }
    use crate::density::consistent;
    use crate::density::tests::{draws, noise, on_the_line, root, scattered, stock};
    use crate::state::HEIGHT;
    use crate::wish::grant;
    use deeptree_graph::Seed;
    use deeptree_infer::Root;

    const OWN: Place = Place { age: 35.0, gravitropism: 0.0 };

    /// Many roots of one age and gravitropism, and some scattered over ages from 10 to 40.
    fn roots() -> Vec<Root> {
        let mut source = draws(8);
        let mut roots: Vec<Root> = (0..400)
            .map(|_| noise(&mut source))
            .map(|noise| {
                let line = on_the_line(OWN);
                root(OWN, &std::array::from_fn(|i| line[i] + noise[i]))
            })
            .collect();
        roots.extend(scattered(9, 300, 1.0));
        roots
    }

    fn of_height(height: f32) -> Request {
        let wishes = Wishes { height: Some(height), ..Wishes::default() };
        Request { wishes, ..Request::new("oak", Seed(0)) }
    }

    #[test]
    fn a_wish_beyond_the_own_age_moves_the_age_as_little_as_it_takes() {
        let roots = roots();
        let at_home = aim(stock(&roots), &of_height(28.0)).unwrap();
        assert_eq!(at_home.place, OWN);
        let strain = |law: &Law, height: f32| law.strain(HEIGHT, f64::from(height));
        assert!(strain(&at_home.law, 25.5) < EASE_AT_HOME);
        assert_eq!(aim(stock(&roots), &of_height(25.5)).unwrap().place, OWN);
        for height in [23.0, 23.5, 24.0] {
            let request = of_height(height);
            assert!(strain(&at_home.law, height) > EASE_AT_HOME);
            let Aim { place, law } = aim(stock(&roots), &request).unwrap();
            assert!(place.age < OWN.age && place.gravitropism == OWN.gravitropism, "{place:?}");
            assert!(strain(&law, height) <= EASE_AWAY);
            for age in (place.age as u16 + 1)..35 {
                let asked = Request { age: Some(age), ..request.clone() };
                let other = aim(stock(&roots), &asked).unwrap();
                assert!(strain(&other.law, height) > EASE_AWAY, "{age} has {height}");
            }
            for seed in 0..100 {
                let (_, state) = law.draw(&mut draws(seed));
                let granted = consistent(grant(state, &law, &request.wishes));
                assert_eq!(granted[HEIGHT], f64::from(height));
            }
        }
    }

    #[test]
    fn a_wish_that_is_seldom_at_any_age_gets_the_age_where_it_is_least_seldom() {
        let roots = roots();
        // Two deviations above the mean of the oldest, more above that of the own age.
        let Aim { place, law } = aim(stock(&roots), &of_height(33.5)).unwrap();
        assert!(place.age > OWN.age && law.strain(HEIGHT, 33.5) > EASE_AWAY, "{place:?}");
        for age in [20, 30, 35, 38, 40] {
            let asked = Request { age: Some(age), ..of_height(33.5) };
            let other = aim(stock(&roots), &asked).map(|other| other.law.strain(HEIGHT, 33.5));
            assert!(other.is_err() || other.unwrap() >= law.strain(HEIGHT, 33.5));
        }
    }

    #[test]
    fn a_wish_that_the_asked_age_has_not_is_refused_with_its_range() {
        let roots = roots();
        let request = Request { age: Some(35), ..of_height(18.0) };
        let error = aim(stock(&roots), &request).unwrap_err();
        let GenerateError::OutOfRange { age: Some(35.0), what: "height", low, high, .. } = error
        else {
            panic!("{error}")
        };
        // The mean height at the own age is 28.3 m, its deviation 2.1 m.
        assert!((19.0..24.0).contains(&low) && (33.0..38.0).contains(&high), "{low} {high}");
        assert!(aim(stock(&roots), &Request { age: Some(35), ..of_height(low) }).is_ok());
        let granted = clamp(stock(&roots), &request).unwrap();
        assert_eq!(granted.height, Some(low));
    }

    #[test]
    fn a_wish_that_no_age_has_is_refused_with_the_range_of_all() {
        let roots = roots();
        for height in [2.0, 300.0] {
            let error = aim(stock(&roots), &of_height(height)).unwrap_err();
            let GenerateError::OutOfRange { age: None, low, high, .. } = error else {
                panic!("{error}")
            };
            // From 21.8 m at age 10 to 29.6 m at age 40, by two or three deviations.
            assert!((14.0..19.0).contains(&low) && (33.0..39.0).contains(&high), "{low} {high}");
            let wishes = clamp(stock(&roots), &of_height(height)).unwrap();
            assert_eq!(wishes.height, Some(if height < low { low } else { high }));
            assert!(aim(stock(&roots), &Request { wishes, ..of_height(0.0) }).is_ok());
        }
        let nan = aim(stock(&roots), &of_height(f32::NAN)).unwrap_err();
        assert!(matches!(nan, GenerateError::NotFinite { what: "height", .. }));
    }

    #[test]
    fn wishes_that_no_age_has_at_once_are_told_and_moved_home() {
        let roots = roots();
        // Each is seen at some age: few branches at 10, the greatest heights at 40.
        let wishes = Wishes { height: Some(34.0), branches: Some(200.0), ..Wishes::default() };
        let request = Request { wishes, ..of_height(0.0) };
        let error = aim(stock(&roots), &request).unwrap_err();
        assert!(matches!(error, GenerateError::NotTogether { .. }), "{error}");
        let wishes = clamp(stock(&roots), &request).unwrap();
        assert_eq!(aim(stock(&roots), &Request { wishes, ..request }).unwrap().place, OWN);
    }

    #[test]
    fn places_in_between_are_drawn_for_and_places_beyond_are_not() {
        let roots = scattered(2, 300, 1.0);
        let at = |age, gravitropism| {
            let request =
                Request { age: Some(age), gravitropism: Some(gravitropism), ..of_height(0.0) };
            aim(stock(&roots), &Request { wishes: Wishes::default(), ..request })
        };
        for (age, gravitropism) in [(25, 0.0), (25, 0.2), (16, -0.2), (12, 0.35)] {
            let place = at(age, gravitropism).unwrap().place;
            assert_eq!((place.age, place.gravitropism), (f32::from(age), gravitropism));
        }
        assert!(matches!(at(50, 0.0), Err(GenerateError::OutOfRange { what: "age", .. })));
        let low = at(25, -0.5).unwrap_err();
        assert!(matches!(low, GenerateError::OutOfRange { what: "gravitropism", .. }), "{low}");
        // Young trees that grow upwards and old ones that droop say nothing of young ones that do.
        let mut corners = roots;
        corners.retain(|r| (r.age > 30.0) == (r.gravitropism > 0.2));
        let request = Request { age: Some(12), gravitropism: Some(0.38), ..of_height(0.0) };
        let error = aim(stock(&corners), &Request { wishes: Wishes::default(), ..request });
        assert!(matches!(error, Err(GenerateError::NotSeen { .. })), "{error:?}");
    }
}
