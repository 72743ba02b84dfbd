//! Results as Parquet: the columns of the CSV file with their types, units and meanings, and the study in the
//! file's metadata.
//!
//! A file is made from the complete rows, so its bytes depend on nothing else. Numbers have the bits that the
//! CSV file writes: the reader gives back each row's line of CSV, whose checksum is the one in the row.

mod pages;
mod ticks;

pub(super) use ticks::Ticks;

use super::origin::Origin;
use super::{SweepError, row};
use crate::columns::{self, Columns};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder,
};
use parquet::basic::Compression;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use std::fs::File;
use std::io::{self, Read, Write};

/// Rows that are read or written at a time.
const BATCH: usize = 1024;
/// Rows of a row group, which is in memory while it is written.
const ROW_GROUP: usize = 1 << 16;
/// The key of the study's text in a file's metadata.
const STUDY: &str = "cocarry.study";
/// The key of the study's digest.
const DIGEST: &str = "cocarry.study_digest";
/// The key of the arithmetic's stamp.
const ARITHMETIC: &str = "cocarry.arithmetic";

/// The check that this program can write such files: it can.
pub(super) fn check(_: &str) -> std::result::Result<(), SweepError> {
    Ok(())
}

/// How files of these rows are written.
fn properties(origin: &Origin) -> WriterProperties {
    let pairs = [
        ("cocarry.version", Some(env!("CARGO_PKG_VERSION").to_owned())),
        (STUDY, origin.text.clone()),
        (DIGEST, Some(origin.study.clone())),
        ("cocarry.episodes", Some(origin.episodes.to_string())),
        (ARITHMETIC, Some(origin.arithmetic.clone())),
    ];
    let pairs = pairs.into_iter().filter(|(_, value)| value.is_some());
    WriterProperties::builder()
        .set_compression(Compression::ZSTD(Default::default()))
        .set_max_row_group_row_count(Some(ROW_GROUP))
        .set_key_value_metadata(Some(
            pairs.map(|(key, value)| KeyValue::new(key.to_owned(), value)).collect(),
        ))
        .build()
}

/// Writes the rows of a CSV file of results.
pub(super) fn write(lines: impl Read, out: impl Write + Send, origin: &Origin) -> io::Result<()> {
    written(lines, out, origin).map_err(system_error)
}

/// The system's error, where a file cannot be written.
fn system_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast() {
            Ok(error) => *error,
            Err(source) => io::Error::other(source),
        },
        other => io::Error::other(other),
    }
}

fn written(lines: impl Read, out: impl Write + Send, origin: &Origin) -> Result<()> {
    let headings = row::headings();
    let columns = || Columns::new(&headings);
    let mut writer = ArrowWriter::try_new(out, columns().schema().clone(), Some(properties(origin)))?;
    let mut reader = csv::ReaderBuilder::new().from_reader(lines);
    let mut fields = csv::StringRecord::new();
    loop {
        let (mut batch, mut count) = (columns(), 0);
        while count < BATCH
            && reader.read_record(&mut fields).map_err(|error| ParquetError::External(error.into()))?
        {
            batch.add(&fields, []);
            count += 1;
        }
        writer.write(&batch.batch()?)?;
        if count < BATCH {
            writer.close()?;
            return Ok(());
        }
    }
}

/// The error of a file that cannot be read.
fn unread(file: &str, error: ParquetError) -> SweepError {
    SweepError::parquet(file.to_owned(), error.into())
}

/// The value of a key of a file's metadata.
fn value_of<'m>(pairs: Option<&'m Vec<KeyValue>>, key: &str) -> Option<&'m str> {
    pairs?.iter().find(|pair| pair.key == key)?.value.as_deref()
}

/// Runs a function of the Parquet library, which may panic where a file is damaged.
fn guarded<T>(read: impl FnOnce() -> Result<T>) -> Result<T> {
    let done = cocarry::guarded::here(read);
    done.unwrap_or_else(|_| Err(ParquetError::General("the file is damaged".to_owned())))
}

/// Opens a file; its columns have the types of Parquet, whatever a writer notes about Arrow's.
fn open(file: File) -> Result<ParquetRecordBatchReaderBuilder<File>> {
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    pages::check_description(&file)?;
    guarded(|| ParquetRecordBatchReaderBuilder::try_new_with_options(file, options))
}

/// The batches of a file whose texts are shared: a value that is repeated is in memory once.
fn batches(file: File, builder: &ParquetRecordBatchReaderBuilder<File>) -> Result<ParquetRecordBatchReader> {
    pages::check_pages(&file, builder.metadata())?;
    let shared = |field: &std::sync::Arc<Field>| match field.data_type() {
        DataType::Utf8 => Field::new(field.name(), DataType::Utf8View, field.is_nullable()),
        _ => Field::clone(field),
    };
    let schema = Schema::new(builder.schema().fields().iter().map(shared).collect::<Vec<_>>());
    let options = ArrowReaderOptions::new().with_schema(schema.into());
    let metadata = ArrowReaderMetadata::try_new(builder.metadata().clone(), options)?;
    ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata).with_batch_size(BATCH).build()
}

/// A reader of the rows of a Parquet file of results.
pub(super) struct RowReader {
    name: String,
    batches: ParquetRecordBatchReader,
    batch: Option<RecordBatch>,
    /// The next row of the batch.
    next: usize,
    study_text: Option<String>,
}

impl RowReader {
    /// Opens the file and checks names and types of its columns.
    pub fn open(file: File, name: &str) -> std::result::Result<Self, SweepError> {
        let unread = |error| unread(name, error);
        let again = file.try_clone().map_err(|error| unread(error.into()))?;
        let builder = open(file).map_err(unread)?;
        check_columns(builder.schema().fields(), name)?;
        let pairs = builder.metadata().file_metadata().key_value_metadata();
        let study_text = value_of(pairs, STUDY).map(str::to_owned);
        let batches = guarded(|| batches(again, &builder)).map_err(unread)?;
        Ok(Self { name: name.to_owned(), batches, batch: None, next: 0, study_text })
    }

    /// The text of the study, if the file has it.
    pub fn study_text(&self) -> Option<&str> {
        self.study_text.as_deref()
    }

    /// The next row as a line of CSV; empty at the end.
    pub fn next(&mut self) -> std::result::Result<Vec<u8>, SweepError> {
        self.line().map_err(|error| unread(&self.name, error))
    }

    fn line(&mut self) -> Result<Vec<u8>> {
        while self.batch.as_ref().is_none_or(|batch| self.next >= batch.num_rows()) {
            let Some(batch) = guarded(|| Ok(self.batches.next().transpose()?))? else {
                return Ok(Vec::new());
            };
            self.batch = Some(batch);
            self.next = 0;
        }
        let row = self.next;
        self.next += 1;
        let columns = self.batch.iter().flat_map(RecordBatch::columns);
        Ok(row::line_of_cells(columns.map(|column| cell(column, row))))
    }
}

/// A value as the CSV file has it.
fn cell(column: &ArrayRef, row: usize) -> String {
    if column.is_null(row) {
        return String::new();
    }
    match column.data_type() {
        DataType::Float64 => column.as_primitive::<Float64Type>().value(row).to_string(),
        DataType::Int64 => column.as_primitive::<Int64Type>().value(row).to_string(),
        DataType::Boolean => column.as_boolean().value(row).to_string(),
        // the columns are checked
        _ => column.as_string_view_opt().map_or("", |texts| texts.value(row)).to_owned(),
    }
}

/// The check that the columns are those of this version.
fn check_columns(found: &[std::sync::Arc<Field>], file: &str) -> std::result::Result<(), SweepError> {
    let expected: Vec<Field> = row::headings().iter().map(columns::field).collect();
    let words = |field: Option<&Field>| match field {
        Some(field) => {
            let name: String = field.name().chars().take(60).collect();
            format!("`{name}` of type {}", field.data_type())
        }
        None => "none".to_owned(),
    };
    for column in 0..found.len().max(expected.len()) {
        let (found, expected) = (found.get(column).map(AsRef::as_ref), expected.get(column));
        let same = |(a, b): (&Field, &Field)| (a.name(), a.data_type()) == (b.name(), b.data_type());
        if !found.zip(expected).is_some_and(same) {
            return Err(SweepError::columns(file.to_owned(), column + 1, words(found), words(expected)));
        }
    }
    Ok(())
}
