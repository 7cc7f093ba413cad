//! What is known of the people of a population: the labels beside their faces, and which faces are of one person.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde_json::{Number, Value};

use super::persons::Persons;
use crate::fit::format::ply;
use crate::fit::format::text::{Members, decoded, json, plain};
use crate::fit::head::generic_head::ETHNICITIES;
use crate::fit::{FitError, FitResult};

/// The format of `labels.json` and `labels.csv`, for `--help`.
pub const FORMAT: &str = r#"labels.json holds an object for each face, by the name of its file without its ending:
  {"anna": {"person": "A", "age": 34, "sex": 0, "ethnicity": [0, 0.5, 0.5], "scanner": {"height": 1.2}},
   "anna again": {"person": "A", "age": 36, "sex": 0}, "emil": {"age": null, "sex": 1}}
A number is a label; what is text for all who have it, as notes are, is none, and is left out and named. "sex" goes from 0
for female to 1 for male. "ethnicity" is three shares, African, Asian and Caucasian, which sum to 1. The numbers of an
object in it are what else is known of a person: their part of the faces is taken out before labels are learned. Who has
no value of a label (null, or nothing), or is not there at all, is left out for that label alone. "person" is no label:
faces with the same text or number there are scans of one person, who is held out whole and counts once; a face without it
is a person by itself.
labels.csv may be there in its place, a table with a row a face: the columns are called name, person (or no such column),
and as labels are; african, asian and caucasian together are the three shares, as they are in labels.json. Between columns
are commas, semicolons or tabs; beside the latter two 0,5 is a half. An empty cell, or NA, is what is not known; rows and
columns of empty cells are none, nor is a first column without a name, where R and pandas count rows."#;

/// The label that is three shares.
const SHARES: &str = "ethnicity";

/// What is no label, but whom a face is of.
const PERSON: &str = "person";

/// How it is told of what sex somebody is.
const SEX: &str = ", where 0 is female and 1 is male";

/// Three shares sum to 1 but for how they are rounded: thirds in hundredths are a hundredth short of it.
const ROUNDED: f64 = 0.01 + 1e-9;

/// What is told of faces, by their names.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    path: PathBuf,
    faces: BTreeMap<String, BTreeMap<String, Value>>,
    /// What is text for all faces, and so no label.
    text: BTreeSet<String>,
}

impl Told {
    /// The files that tell it, of which one may be beside the faces.
    pub const FILES: [&'static str; 2] = ["labels.json", "labels.csv"];

    /// Reads what is told of the faces of a folder, where anything is ([`FORMAT`]).
    ///
    /// # Errors
    /// When the file cannot be read, or says of a face what is no label: with the face and the label, and of a table
    /// with row and column. And when two files are there, which might not say the same.
    pub fn beside(folder: &Path) -> FitResult<Option<Self>> {
        let there = Self::FILES.map(|name| folder.join(name));
        match there.each_ref().map(|path| path.exists()) {
            [true, true] => {
                let cause = "is there beside labels.json: one of them is to stay";
                Err(FitError::file(&there[1], cause))
            }
            [true, false] => Self::json(&there[0]).map(Some),
            [false, true] => Self::csv(&there[1]).map(Some),
            [false, false] => Ok(None),
        }
    }

    fn json(path: &Path) -> FitResult<Self> {
        let Members(told): Members<Members<Value>> = json(path)?;
        let faces = told.into_iter();
        let faces = faces.map(|(face, labels)| (face, labels.0.into_iter().collect()));
        let mut faces: BTreeMap<String, BTreeMap<String, Value>> = faces.collect();
        let text = texts(faces.values().flatten().filter_map(|(label, value)| {
            let text = value.as_str().filter(|text| is_text(text));
            (!value.is_null()).then_some((label.as_str(), text.is_some()))
        }));
        let is_label = |label: &String| !text.contains(label);
        (faces.values_mut()).for_each(|labels| labels.retain(|label, _| is_label(label)));
        let fail = |face: &str, cause: &str| FitError::file(path, format!("{face}: its {cause}"));
        let known = |value: Option<&Value>| value.is_some_and(|value| !value.is_null());
        for (face, labels) in &mut faces {
            if ETHNICITIES.iter().all(|&share| known(labels.get(share)))
                && !known(labels.get(SHARES))
            {
                let shares = ETHNICITIES.iter().filter_map(|&share| labels.remove(share));
                let shares = Value::Array(shares.collect());
                labels.insert(SHARES.to_owned(), shares);
            }
            for (label, value) in &*labels {
                if let Some(fault) = fault(label, value) {
                    return Err(fail(face, &fault));
                }
            }
        }
        // They would be two labels of one name.
        if faces.values().any(|labels| known(labels.get(SHARES))) {
            for (face, labels) in &faces {
                let one = ETHNICITIES.iter().find(|&&share| known(labels.get(share)));
                if let Some(share) = one {
                    let cause = format!("{share} is one of the shares that {SHARES:?} has");
                    return Err(fail(face, &cause));
                }
            }
        }
        Ok(Self {
            path: path.to_owned(),
            faces,
            text,
        })
    }

    fn csv(path: &Path) -> FitResult<Self> {
        let fail = |cause: String| FitError::file(path, cause);
        let bytes = std::fs::read(path).map_err(|e| FitError::unread(path, e))?;
        let bytes = plain(&bytes).map_err(&fail)?;
        let text = decoded(&bytes);
        let (delimiter, mut table, columns) = table(&text)
            .map_err(|e| FitError::file(path, e))?
            .ok_or_else(|| {
                fail(format!(
                    "it has no column called {NAME:?}, separated from others by commas, semicolons or tabs"
                ))
            })?;
        let columns: Vec<&str> = columns.iter().collect();
        check_columns(&columns).map_err(&fail)?;
        let records: Vec<_> = (table.records())
            .collect::<csv::Result<_>>()
            .map_err(|e| FitError::file(path, e))?;
        let cells = records.iter().flat_map(|record| columns.iter().zip(record));
        let known = cells.filter(|(column, cell)| !column.is_empty() && !is_unknown(cell));
        let text = texts(known.map(|(&column, cell)| (column, is_text(cell))));
        let mut faces = BTreeMap::new();
        let mut rows = BTreeMap::new();
        for record in &records {
            let row = record.position().map_or(0, csv::Position::line);
            let bad = |column: &str, cause: String| {
                Err(fail(format!("row {row}, column {column}: {cause}")))
            };
            // Spreadsheets write the rows and columns that something was in once, too.
            if record.iter().all(str::is_empty) {
                continue;
            }
            // In the first column R and pandas count rows.
            let mut rest = columns.iter().zip(record).zip(1..).skip(1);
            let unnamed = rest.find(|((column, cell), _)| column.is_empty() && !cell.is_empty());
            if let Some((_, i)) = unnamed {
                return Err(fail(format!("its column {i} has no name")));
            }
            let mut cells: BTreeMap<&str, &str> = columns.iter().copied().zip(record).collect();
            cells.remove("");
            cells.retain(|&column, cell| match column {
                NAME => !cell.is_empty(),
                _ => !is_unknown(cell) && !text.contains(column),
            });
            let Some(name) = cells.remove(NAME) else {
                return bad(NAME, "it is empty".into());
            };
            if let Some(before) = rows.insert(name.to_owned(), row) {
                return bad(NAME, format!("{name} is there before, in row {before}"));
            }
            let mut labels = BTreeMap::new();
            if let Some(person) = cells.remove(PERSON) {
                labels.insert(PERSON.to_owned(), Value::from(person));
            }
            let mut numbers = BTreeMap::new();
            for (column, cell) in cells {
                let point = match delimiter {
                    b',' => cell.into(),
                    _ => cell.replace(',', "."),
                };
                let Some(number) = point.parse().ok().and_then(Number::from_f64) else {
                    let coded = if column == "sex" { SEX } else { "" };
                    return bad(column, format!("{cell:?} is no number{coded}"));
                };
                numbers.insert(column.to_owned(), Value::Number(number));
            }
            let shares = ETHNICITIES.map(|share| numbers.remove(share));
            let missing = ETHNICITIES.iter().zip(&shares).find(|(_, s)| s.is_none());
            match missing {
                None => {
                    let shares = shares.into_iter().flatten().collect();
                    numbers.insert(SHARES.to_owned(), Value::Array(shares));
                }
                Some((share, _)) if shares.iter().any(Option::is_some) => {
                    return bad(share, "it is empty, and the other shares are not".into());
                }
                Some(_) => {}
            }
            labels.extend(numbers);
            for (label, value) in &labels {
                if let Some(fault) = fault(label, value) {
                    let column = match label == SHARES {
                        true => &ETHNICITIES.join(", "),
                        false => label,
                    };
                    return bad(column, format!("{name}: its {fault}"));
                }
            }
            faces.insert(name.to_owned(), labels);
        }
        Ok(Self {
            path: path.to_owned(),
            faces,
            text,
        })
    }

    /// The file that it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whom a face is told to be of: text, or a number as text.
    pub fn person(&self, face: &str) -> Option<String> {
        match self.faces.get(face)?.get(PERSON)? {
            Value::String(person) => Some(person.clone()),
            // 1.0 is who 1 is; of whole numbers all digits count.
            Value::Number(number) => match number.as_f64() {
                Some(x) if number.is_f64() => Some(x.to_string()),
                _ => Some(number.to_string()),
            },
            _ => None,
        }
    }

    /// Whether it is told of any face whose it is.
    pub fn has_persons(&self) -> bool {
        self.faces.keys().any(|face| self.person(face).is_some())
    }

    /// Whether anything else is told of any face.
    pub fn has_labels(&self) -> bool {
        let mut labels = self.faces.values().flat_map(BTreeMap::keys);
        labels.any(|label| label != PERSON)
    }

    /// One line about what is told in words alone, and is no label, where there is any.
    pub fn in_words(&self) -> Option<String> {
        let all: Vec<String> = self.text.iter().map(|label| format!("{label:?}")).collect();
        (!all.is_empty()).then(|| {
            let path = self.path.display();
            format!(
                "{path}: text, no numbers, and so no labels: {}",
                all.join(", ")
            )
        })
    }

    /// One line about the names in it that are of no face of a folder, where there are any.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn of_no_face(&self, folder: &Path) -> FitResult<Option<String>> {
        /// So many are named.
        const NAMED: usize = 5;
        let faces = ply::faces(folder)?;
        let there: BTreeSet<_> = faces.iter().filter_map(|path| path.file_stem()).collect();
        let strange = self.faces.keys();
        let strange: Vec<&str> = strange
            .map(String::as_str)
            .filter(|name| !there.contains(std::ffi::OsStr::new(name)))
            .collect();
        if strange.is_empty() {
            return Ok(None);
        }
        let first = strange.iter().take(NAMED).copied();
        let first: Vec<&str> = first.collect();
        let more = if strange.len() > NAMED { ", ..." } else { "" };
        Ok(Some(format!(
            "{}: {} of its names are of no face there: {}{more}",
            self.path.display(),
            strange.len(),
            first.join(", ")
        )))
    }
}

/// The column of a face's name.
const NAME: &str = "name";

/// What stands in a cell of which nothing is known, as R writes it.
const UNKNOWN: &str = "NA";

/// Whether nothing is known by a cell.
fn is_unknown(cell: &str) -> bool {
    cell.is_empty() || cell == UNKNOWN
}

/// Whether a word is text, and no number, nor one that is written otherwise than numbers are read.
fn is_text(word: &str) -> bool {
    let digits = word.trim_start_matches(['+', '-']);
    let digits = digits.trim_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | ','));
    word.is_empty() || (!digits.is_empty() && word.parse::<f64>().is_err())
}

/// What is text for all who have it, of labels and whether they are. Of those that have a meaning of their own none is:
/// who writes text there means it, and is told how it is written.
fn texts<'a>(told: impl Iterator<Item = (&'a str, bool)>) -> BTreeSet<String> {
    let mut all: BTreeMap<&str, bool> = BTreeMap::new();
    for (label, is_text) in told {
        *all.entry(label).or_insert(true) &= is_text;
    }
    let meant = [NAME, PERSON, SHARES, "sex"];
    let text = all.into_iter().filter(|(label, is_text)| {
        *is_text && !meant.contains(label) && !ETHNICITIES.contains(label)
    });
    text.map(|(label, _)| label.to_owned()).collect()
}

/// A table with its columns' names, by what is between them: the first of the usual with which one of them is a face's name.
type Table<'a> = (u8, csv::Reader<&'a [u8]>, csv::StringRecord);

fn table(text: &str) -> csv::Result<Option<Table<'_>>> {
    for delimiter in *b",;\t" {
        let mut table = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let columns = table.headers()?.clone();
        if columns.iter().any(|column| column == NAME) {
            return Ok(Some((delimiter, table, columns)));
        }
    }
    Ok(None)
}

/// Refuses a table's head in which columns are there twice, or not as they are meant.
fn check_columns(columns: &[&str]) -> Result<(), String> {
    for (i, column) in columns.iter().enumerate() {
        if !column.is_empty() && columns[..i].contains(column) {
            return Err(format!("it has two columns called {column:?}"));
        }
    }
    let shares = ETHNICITIES.iter().filter(|share| columns.contains(share));
    if columns.contains(&SHARES) || (1..ETHNICITIES.len()).contains(&shares.count()) {
        return Err(format!(
            "{SHARES:?} is the three columns {} together",
            ETHNICITIES.join(", ")
        ));
    }
    Ok(())
}

/// What is wrong with what is told as a label, if anything.
fn fault(label: &str, value: &Value) -> Option<String> {
    let is = |what: &str| Some(format!("{label} is {what}"));
    match value {
        _ if label.trim().is_empty() => Some("label has no name".into()),
        Value::String(person) if label == PERSON && !person.trim().is_empty() => None,
        Value::Number(_) | Value::Null if label == PERSON => None,
        _ if label == PERSON => is("neither text nor a number"),
        Value::Null => None,
        Value::Number(number) => {
            let coded = |sex: f64| (0.0..=1.0).contains(&sex);
            match label == "sex" && !number.as_f64().is_some_and(coded) {
                true => is(&format!("{number}{SEX}")),
                false => None,
            }
        }
        Value::Array(shares) if label == SHARES => {
            let numbers: Option<Vec<f64>> = shares.iter().map(Value::as_f64).collect();
            let Some(shares) = numbers.filter(|n| n.len() == ETHNICITIES.len()) else {
                return is("not three numbers");
            };
            let sum: f64 = shares.iter().sum();
            if shares.iter().any(|&share| share < 0.0) {
                is("three shares of which one is below 0")
            } else if (sum - 1.0).abs() > ROUNDED {
                is(&format!("three shares that sum to {sum:.3}, and not to 1"))
            } else {
                None
            }
        }
        Value::Object(more) => {
            let mut more = more.iter();
            let bad = more.find(|(_, value)| !value.is_number() && !value.is_null());
            bad.map(|(name, _)| format!("{label}, {name} is no number"))
        }
        _ if label == "sex" => is(&format!("no number{SEX}")),
        _ => is("no number"),
    }
}

/// The labels of a population, one value a face, where it is known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Labels {
    /// Whose faces they are.
    pub persons: Persons,
    /// What may be learned, by name.
    pub told: Vec<(String, Vec<Option<f64>>)>,
    /// Which of these are learned, and which together: shares, which sum to 1, as one, all else alone.
    pub together: Vec<Range<usize>>,
    /// What else is known of each face. Its part of the faces is taken out of them first, so that
    /// it is not taken for that of a label. Who has no value counts as the mean.
    pub besides: Vec<Vec<f64>>,
}

impl Labels {
    /// What is told of the named faces. Who else is told of does not count.
    pub fn of(told: &Told, names: &[String]) -> Self {
        let people: Vec<_> = names.iter().map(|name| told.faces.get(name)).collect();
        let mut labels = Labels {
            persons: Persons::told(names, told),
            ..Labels::default()
        };
        // Of all that anybody has, by name: shares apart from a number of that name.
        let (mut told, mut besides) = (BTreeSet::new(), BTreeSet::new());
        let all = people.iter().copied().flatten().flatten();
        for (label, value) in all.filter(|(label, _)| *label != PERSON) {
            match value {
                Value::Object(more) => besides.extend(more.keys().map(|name| (label, name))),
                Value::Null => {}
                value => {
                    told.insert((label, value.is_array()));
                }
            }
        }
        let of = |person: &Option<&BTreeMap<String, Value>>, label: &str| -> Option<Value> {
            person.and_then(|labels| labels.get(label)).cloned()
        };
        for (label, is_shares) in told {
            let first = labels.told.len();
            let values = || people.iter().map(|person| of(person, label));
            match is_shares {
                true => {
                    for (i, name) in ETHNICITIES.into_iter().enumerate() {
                        // As they are learned together they sum to 1, however they were rounded.
                        let share = |value: Option<Value>| {
                            let value = value?;
                            let all = value.as_array()?.iter().filter_map(Value::as_f64);
                            Some(value.get(i)?.as_f64()? / all.sum::<f64>())
                        };
                        labels
                            .told
                            .push((name.into(), values().map(share).collect()));
                    }
                }
                false => {
                    let number = |value: Option<Value>| value?.as_f64();
                    labels
                        .told
                        .push((label.clone(), values().map(number).collect()));
                }
            }
            labels.together.push(first..labels.told.len());
        }
        for (label, name) in besides {
            let number = |person| of(person, label)?.get(name)?.as_f64();
            let column: Vec<Option<f64>> = people.iter().map(number).collect();
            let known: Vec<f64> = column.iter().copied().flatten().collect();
            let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
            labels
                .besides
                .push(column.iter().map(|x| x.unwrap_or(mean)).collect());
        }
        labels
    }

    /// Leaves only some of the labels to be learned; three shares are called `"ethnicity"`. What else is known stays.
    ///
    /// # Errors
    /// When there is no label of a name, with those that there are.
    pub fn only(&mut self, wanted: &[String]) -> FitResult<()> {
        let name = |own: &Range<usize>| match own.len() {
            1 => self.told[own.start].0.as_str(),
            _ => SHARES,
        };
        let names: Vec<&str> = self.together.iter().map(name).collect();
        if let Some(strange) = wanted.iter().find(|name| !names.contains(&name.as_str())) {
            return Err(FitError::Input(format!(
                "no label of these faces is called {strange:?}; there are {}",
                names.join(", ")
            )));
        }
        let is_wanted = |own: &&Range<usize>| wanted.iter().any(|wanted| wanted == name(own));
        let kept: Vec<Range<usize>> = self.together.iter().filter(is_wanted).cloned().collect();
        self.together = kept;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a file tells of the faces a and b, and its labels.
    fn read(name: &str, text: impl AsRef<[u8]>) -> FitResult<(Told, Labels)> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), text).unwrap();
        let told = Told::beside(folder.path())?.expect("a file");
        let labels = Labels::of(&told, &["a", "b"].map(str::to_owned));
        Ok((told, labels))
    }

    #[test]
    fn labels_are_read_or_refused_with_the_face_named() {
        let labels = |text: &str| read("labels.json", text).unwrap().1;
        let all = labels(
            r#"{"a": {"age": 20, "ethnicity": [0.2, 0.3, 0.5], "local": {"nose": 1}},
                "b": {"age": 30, "ethnicity": [1, 0, 0], "local": {"nose": -1}},
                "of no face": {"height": 170}}"#,
        );
        let told: Vec<&str> = all.told.iter().map(|t| t.0.as_str()).collect();
        assert_eq!(told, ["age", "african", "asian", "caucasian"]);
        assert_eq!(all.told[0].1, [20.0, 30.0].map(Some));
        assert_eq!(all.told[3].1, [0.5, 0.0].map(Some));
        assert_eq!(all.together, [0..1, 1..4]);
        assert_eq!(all.besides, [[1.0, -1.0]]);
        // As Windows writes text.
        let text = "\u{feff}{\"a\": {\"age\": 20}, \"b\": {\"age\": 30}}";
        assert_eq!(labels(text).told[0].1, [20.0, 30.0].map(Some));
        // Who has no value, or is not there, is known less of; what else is known of others counts as its mean.
        let text = r#"{"a": {"age": 20, "sex": null, "ethnicity": null, "local": {"nose": 1}}}"#;
        let few = labels(text);
        assert_eq!(few.told, [("age".into(), vec![Some(20.0), None])]);
        assert_eq!(few.besides, [[1.0, 1.0]]);
        let sparse = [
            ("age".into(), vec![Some(20.0), None]),
            ("sex".into(), vec![None, Some(1.0)]),
        ];
        assert_eq!(
            labels(r#"{"b": {"sex": 1}, "a": {"age": 20}}"#).told,
            sparse
        );
        // Thirds in hundredths are shares, and sum to 1 when they are learned from.
        let thirds = labels(r#"{"a": {"ethnicity": [0.33, 0.33, 0.33]}}"#);
        let thirds = thirds.told.iter().map(|(_, values)| values[0].unwrap());
        // Each is rounded once.
        assert!(
            thirds.clone().count() == 3
                && thirds.into_iter().all(|t| (3.0 * t - 1.0).abs() < 1e-15)
        );
        // The example of the help is one.
        let example = FORMAT.split_once("ending:").unwrap().1;
        let example = example.split_once("\nA number").unwrap().0;
        let (told, _) = read("labels.json", example).unwrap();
        let names = ["anna", "emil", "anna again"].map(str::to_owned);
        assert_eq!(
            Labels::of(&told, &names).persons.said("faces"),
            "3 scans of 2 people"
        );
        for (text, why) in [
            (
                r#"{"a": {"age": 20}, "b": {"age": "x"}}"#,
                "b: its age is no number",
            ),
            (r#"{"a": {"sex": true}}"#, "a: its sex is no number"),
            (
                r#"{"a": {"sex": 2}}"#,
                "a: its sex is 2, where 0 is female and 1 is male",
            ),
            (r#"{"a": {"sex": -0.1}}"#, "a: its sex is -0.1, where"),
            (
                r#"{"a": {"ethnicity": [1, 0]}}"#,
                "a: its ethnicity is not three numbers",
            ),
            (
                r#"{"a": {"african": 1, "asian": 1, "caucasian": 0}}"#,
                "a: its ethnicity is three shares that sum to 2.000",
            ),
            (
                r#"{"a": {"ethnicity": [1, 0, 0]}, "b": {"asian": 1}}"#,
                "b: its asian is one of the shares that \"ethnicity\" has",
            ),
            (
                r#"{"a": {"sex": "F"}}"#,
                "a: its sex is no number, where 0 is female and 1 is male",
            ),
            (r#"{"a": {"": 2}}"#, "a: its label has no name"),
            (
                r#"{"a": {"ethnicity": [1, 0, "x"]}}"#,
                "a: its ethnicity is not three numbers",
            ),
            (
                r#"{"a": {"ethnicity": [0.5, 0.5, 0.5]}}"#,
                "a: its ethnicity is three shares that sum to 1.500, and not to 1",
            ),
            (
                r#"{"a": {"ethnicity": [-0.5, 0.5, 1]}}"#,
                "a: its ethnicity is three shares of which one is below 0",
            ),
            (
                r#"{"a": {"local": {"nose": "x"}}}"#,
                "a: its local, nose is no number",
            ),
            (
                r#"{"a": {"person": true}}"#,
                "a: its person is neither text nor a number",
            ),
            (
                r#"{"a": {"person": " "}}"#,
                "a: its person is neither text nor a number",
            ),
            ("[]", "labels.json"),
            (
                "{\"a\": {\"age\": 20},\n\"b\": {}, \"a\": {\"age\": 30}}",
                "`a` is there twice at line 2",
            ),
            (
                r#"{"a": {"age": 20, "age": 30}}"#,
                "`age` is there twice at line 1",
            ),
            (r#"{"a": {"age": "20"}}"#, "a: its age is no number"),
            (
                r#"{"a": {"ethnicity": "Asian"}}"#,
                "a: its ethnicity is no number",
            ),
            (r#"{"a": {"age": 1e999}}"#, "out of range at line 1"),
        ] {
            let error = read("labels.json", text).unwrap_err().to_string();
            assert!(
                error.contains(why) && error.contains("labels.json"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_person_is_no_label_and_the_same_as_text_and_as_a_number() {
        let text = r#"{"a": {"person": "1", "sex": 0}, "b": {"person": 1.0}, "c": {"person": null},
                       "d": {"person": 9007199254740993}, "e": {"person": 9007199254740992}, "f": {}}"#;
        let (told, labels) = read("labels.json", text).unwrap();
        assert_eq!(labels.told, [("sex".into(), vec![Some(0.0), None])]);
        assert_eq!(labels.persons.count(), 1);
        assert!(told.has_labels());
        let names = ["d", "a", "c", "b", "e", "f", "g"].map(str::to_owned);
        let persons = Persons::told(&names, &told);
        let of: Vec<usize> = (0..names.len()).map(|face| persons.of(face)).collect();
        assert_eq!(of, [0, 1, 2, 1, 3, 4, 5]);
        let (told, _) = read("labels.json", r#"{"a": {"person": 1}}"#).unwrap();
        assert!(!told.has_labels() && told.has_persons());
        let (told, _) = read("labels.json", r#"{"a": {"person": null, "age": 3}}"#).unwrap();
        assert!(told.has_labels() && !told.has_persons());
    }

    #[test]
    fn a_table_tells_what_an_object_a_face_does() {
        let table = "\u{feff}asian, name,age,person,caucasian,african\r\n\
                     0.3,a,20,Ann,0.5,0.2\r\n,\"b\",30.5,Ann,,\r\n\r\n0,c, ,,1,0\r\n";
        let object = r#"{"a": {"person": "Ann", "age": 20.0, "ethnicity": [0.2, 0.3, 0.5]},
                         "b": {"person": "Ann", "age": 30.5}, "c": {"ethnicity": [0.0, 0.0, 1.0]}}"#;
        let (told, labels) = read("labels.csv", table).unwrap();
        let (same, same_labels) = read("labels.json", object).unwrap();
        assert_eq!(told.faces, same.faces);
        assert_eq!(labels, same_labels);
        // As German spreadsheets write it, with a row and a column that something was in once; and with tabs and R's word.
        let table = "name;age;person;african;asian;caucasian;\r\n\
                     a;20,0;Ann;0,2;0,3;0,5;\r\nb;\"30,5\";Ann;;;;\r\n;;;;;;\r\nc;NA;NA;0;0;1;\r\n";
        assert_eq!(read("labels.csv", table).unwrap().0.faces, same.faces);
        let (tabs, _) = read("labels.csv", table.replace(';', "\t")).unwrap();
        assert_eq!(tabs.faces, same.faces);
        // With rows that are counted.
        let (counted, _) = read("labels.csv", ",name,age\n0,a,20\n1,b,30\n").unwrap();
        let (plain, _) = read("labels.csv", "name,age\na,20\nb,30\n").unwrap();
        assert_eq!(counted.faces, plain.faces);
        // Shares in an object as in a table; alone one is a label as any other.
        let object =
            r#"{"a": {"african": 0.2, "asian": 0.3, "caucasian": 0.5}, "b": {"asian": null}}"#;
        let (_, shares) = read("labels.json", object).unwrap();
        let asian = ("asian".into(), vec![Some(0.3), None]);
        assert_eq!((shares.together.len(), &shares.told[1]), (1, &asian));
        let (_, alone) = read("labels.json", r#"{"a": {"asian": 0.3}}"#).unwrap();
        assert_eq!(alone.told, [asian]);
        // A name in Latin-1.
        let (told, _) = read("labels.csv", b"name,age\nZo\xeb,3\n").unwrap();
        assert!(told.faces.contains_key("Zo\u{eb}"));
        for (text, why) in [
            (
                "name,age\na,20\nb,x\n",
                r#"row 3, column age: "x" is no number"#,
            ),
            (
                "name,age\na,nan\n",
                r#"row 2, column age: "nan" is no number"#,
            ),
            ("name,age\n\na,20\n,30\n", "row 4, column name: it is empty"),
            (
                "name,age\na,20\na,30\n",
                "row 3, column name: a is there before, in row 2",
            ),
            (
                "name,sex\na,2\n",
                "row 2, column sex: a: its sex is 2.0, where 0 is female",
            ),
            (
                "name,african,asian,caucasian\na,0.5,0.5,\n",
                "row 2, column caucasian: it is empty, and the other shares are not",
            ),
            (
                "name,african,asian,caucasian\na,1,1,0\n",
                "row 2, column african, asian, caucasian: a: its ethnicity is three shares that sum to 2.000",
            ),
            (
                "name,african,asian\na,0.5,0.5\n",
                "is the three columns african, asian, caucasian together",
            ),
            ("name,ethnicity\na,2\n", "is the three columns african"),
            ("Name;age\na;20\n", r#"no column called "name""#),
            ("name,age,age\na,20,30\n", r#"two columns called "age""#),
            ("name,\na,20\n", "its column 2 has no name"),
            ("name,,age,\na,,20,3\n", "its column 4 has no name"),
            (
                "name;age\na;1.234,5\n",
                r#"row 2, column age: "1.234,5" is no number"#,
            ),
            ("name,age\na,\"20,5\"\n", r#""20,5" is no number"#),
            (
                "name,sex\na,F\n",
                r#""F" is no number, where 0 is female and 1 is male"#,
            ),
            ("name,age\na,20,30\n", "line: 2"),
        ] {
            let error = read("labels.csv", text).unwrap_err().to_string();
            assert!(
                error.contains(why) && error.contains("labels.csv: "),
                "{error}"
            );
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }

    #[test]
    fn what_is_text_for_all_is_no_label_and_is_named() {
        let table = "name,notes,age,scanner,scanned\na,\"wears glasses, 2\",20,EinScan,2024-05-01\n\
                     b,,30,NA,2024-05-02\n";
        let object = r#"{"a": {"notes": "", "age": 20, "scanner": "EinScan", "scanned": "2024-05-01"},
                         "b": {"notes": "bearded", "age": 30, "scanner": null}}"#;
        for (name, text) in [("labels.csv", table), ("labels.json", object)] {
            let (told, labels) = read(name, text).unwrap();
            assert_eq!(
                labels.told,
                [("age".into(), [20.0, 30.0].map(Some).to_vec())]
            );
            let said = told.in_words().unwrap();
            let end = format!(
                "{name}: text, no numbers, and so no labels: \"notes\", \"scanned\", \"scanner\""
            );
            assert!(said.ends_with(&end), "{said}");
        }
        let (told, _) = read("labels.csv", "name,person,age\na,Ann,20\n").unwrap();
        assert_eq!(told.in_words(), None);
    }

    #[test]
    fn two_files_are_refused_and_names_of_no_face_are_told() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(Told::beside(folder.path()).unwrap(), None);
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let names = ["Anna", "b", "c", "d", "e", "f", "Gina"];
        let rows: Vec<String> = names.iter().map(|name| format!("{name},1")).collect();
        write("labels.csv", &format!("name,age\n{}\n", rows.join("\n")));
        let told = Told::beside(folder.path()).unwrap().unwrap();
        let said = |told: &Told| told.of_no_face(folder.path()).unwrap();
        let all = said(&told).unwrap();
        assert!(
            all.ends_with(
                "labels.csv: 7 of its names are of no face there: Anna, Gina, b, c, d, ..."
            ),
            "{all}"
        );
        names[..6]
            .iter()
            .for_each(|name| write(&format!("{name}.ply"), ""));
        let one = said(&told).unwrap();
        assert!(
            one.ends_with("1 of its names are of no face there: Gina"),
            "{one}"
        );
        write("Gina.PLY", "");
        assert_eq!(said(&told), None);
        write("labels.json", "{}");
        let error = Told::beside(folder.path()).unwrap_err().to_string();
        assert!(
            error.ends_with("labels.csv: is there beside labels.json: one of them is to stay"),
            "{error}"
        );
    }

    #[test]
    fn some_labels_are_chosen_by_name() {
        let text = r#"{"a": {"age": 1, "sex": 1, "ethnicity": [1, 0, 0], "x": {"y": 1}}}"#;
        let (_, labels) = read("labels.json", text).unwrap();
        let chosen = |names: &[&str]| {
            let mut labels = labels.clone();
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            labels.only(&names).map(|()| labels)
        };
        let told = |labels: &Labels| -> Vec<String> {
            let all = labels.together.iter().cloned().flatten();
            all.map(|i| labels.told[i].0.clone()).collect()
        };
        let some = chosen(&["sex", "ethnicity"]).unwrap();
        assert_eq!(told(&some), ["african", "asian", "caucasian", "sex"]);
        assert_eq!(some.besides, labels.besides);
        assert_eq!(told(&chosen(&["age"]).unwrap()), ["age"]);
        // Shares are one, and what else is known is none.
        for name in ["asian", "x", "Age"] {
            let error = chosen(&["age", name]).unwrap_err().to_string();
            let said = format!(
                "no label of these faces is called {name:?}; there are age, ethnicity, sex"
            );
            assert_eq!(error, said);
        }
    }
}
