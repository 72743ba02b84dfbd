//! Columns as Arrow data: the type, the unit and the meaning of each, and its values.
//!
//! A column's type comes from its kind: numbers are 64-bit floats with the same bits, counts 64-bit integers,
//! flags booleans, words UTF-8, lists of records lists of structs. Missing values are null. Unit and meaning
//! are metadata of the field: `unit`, `description`.

use arrow_array::builder::{BooleanBuilder, Float64Builder, Int64Builder, StringBuilder};
use arrow_array::{ArrayRef, ListArray, RecordBatch, StructArray};
use arrow_buffer::{NullBuffer, OffsetBuffer, ScalarBuffer};
use arrow_schema::{ArrowError, DataType, Field, FieldRef, Fields, Schema, SchemaRef};
use cocarry::quantities::{Fields as Record, Heading, QuantityKind, Value};
use std::collections::HashMap;
use std::sync::Arc;

/// The Arrow field of a column: nullable, with its metadata.
pub fn field(heading: &Heading) -> Field {
    let unit = if let QuantityKind::Number(unit) = heading.kind { unit } else { "" };
    let pairs = [("description", heading.description), ("unit", unit)];
    let pairs = pairs.into_iter().filter(|(_, text)| !text.is_empty());
    let metadata = pairs.map(|(key, text)| (key.to_owned(), text.to_owned())).collect::<HashMap<_, _>>();
    Field::new(heading.name, data_type(heading.kind), true).with_metadata(metadata)
}

fn data_type(kind: QuantityKind) -> DataType {
    match kind {
        QuantityKind::Number(_) => DataType::Float64,
        QuantityKind::Count => DataType::Int64,
        QuantityKind::Flag => DataType::Boolean,
        QuantityKind::Text => DataType::Utf8,
        QuantityKind::Numbers => list(DataType::Float64),
        QuantityKind::Record(headings) => record(&headings()),
        QuantityKind::List(headings) => list(record(&headings())),
    }
}

fn list(of: DataType) -> DataType {
    DataType::List(Arc::new(Field::new("item", of, true)))
}

fn record(headings: &[Heading]) -> DataType {
    DataType::Struct(headings.iter().map(field).collect())
}

/// A column while it is filled.
#[derive(Debug)]
pub enum Column {
    /// Real numbers.
    Number(Float64Builder),
    /// Whole numbers.
    Count(Int64Builder),
    /// True or false.
    Flag(BooleanBuilder),
    /// Texts.
    Text(StringBuilder),
    /// Lists of values. A missing list is empty.
    List {
        /// The field of an item.
        item: FieldRef,
        /// All items, one after the other.
        items: Box<Column>,
        /// Where each list begins, and where the last one ends.
        offsets: Vec<i32>,
    },
    /// Records.
    Record {
        /// The fields of a record.
        fields: Fields,
        /// A column for each field.
        columns: Vec<Column>,
        /// Which records there are.
        present: Vec<bool>,
    },
}

impl Column {
    /// An empty column for values of this kind.
    pub fn of(kind: QuantityKind) -> Self {
        Self::of_type(&data_type(kind))
    }

    fn of_type(data_type: &DataType) -> Self {
        match data_type {
            DataType::Float64 => Self::Number(Float64Builder::new()),
            DataType::Int64 => Self::Count(Int64Builder::new()),
            DataType::Boolean => Self::Flag(BooleanBuilder::new()),
            DataType::List(item) => Self::List {
                item: Arc::clone(item),
                items: Box::new(Self::of_type(item.data_type())),
                offsets: vec![0],
            },
            DataType::Struct(fields) => Self::Record {
                fields: fields.clone(),
                columns: fields.iter().map(|field| Self::of_type(field.data_type())).collect(),
                present: Vec::new(),
            },
            _ => Self::Text(StringBuilder::new()),
        }
    }

    /// Adds a cell of a CSV file. An empty cell is missing, and so is one of another kind.
    pub fn add_text(&mut self, text: &str) {
        match self {
            Self::Number(values) => values.append_option(text.parse().ok()),
            Self::Count(values) => values.append_option(text.parse().ok()),
            Self::Flag(values) => values.append_option(text.parse().ok()),
            Self::Text(values) => values.append_option((!text.is_empty()).then_some(text)),
            Self::List { .. } | Self::Record { .. } => self.add(&Value::Missing),
        }
    }

    /// Adds a value. One of another kind is missing.
    pub fn add(&mut self, value: &Value) {
        match self {
            Self::Number(values) => values.append_option(value.as_f64()),
            Self::Count(values) => {
                values.append_option(if let Value::Count(count) = value { Some(*count) } else { None });
            }
            Self::Flag(values) => {
                values.append_option(if let Value::Flag(flag) = value { Some(*flag) } else { None });
            }
            Self::Text(values) => values.append_option(value.as_str()),
            Self::List { items, offsets, .. } => {
                let before = *offsets.last().expect("offsets begin with 0");
                let added = match value {
                    Value::Numbers(list) => list.iter().map(|number| items.add(&(*number).into())).count(),
                    Value::List(list) => list.iter().map(|record| items.add_record(Some(record))).count(),
                    _ => 0,
                };
                offsets.push(before.wrapping_add(added as i32));
            }
            Self::Record { .. } => {
                self.add_record(if let Value::Record(record) = value { Some(record) } else { None });
            }
        }
    }

    /// Adds a record to a column of records.
    fn add_record(&mut self, record: Option<&Record>) {
        let Self::Record { fields, columns, present } = self else { return };
        for (field, column) in fields.iter().zip(columns) {
            column
                .add(record.and_then(|record| record.get(field.name().as_str())).unwrap_or(&Value::Missing));
        }
        present.push(record.is_some());
    }

    /// The values.
    ///
    /// # Errors
    /// More items of lists than an offset of 32 bits can count.
    pub fn array(self) -> Result<ArrayRef, ArrowError> {
        Ok(match self {
            Self::Number(mut values) => Arc::new(values.finish()),
            Self::Count(mut values) => Arc::new(values.finish()),
            Self::Flag(mut values) => Arc::new(values.finish()),
            Self::Text(mut values) => Arc::new(values.finish()),
            Self::List { item, items, offsets } => {
                if offsets.iter().any(|offset| *offset < 0) {
                    return Err(ArrowError::OffsetOverflowError(offsets.len()));
                }
                let offsets = OffsetBuffer::new(ScalarBuffer::from(offsets));
                Arc::new(ListArray::try_new(item, offsets, items.array()?, None)?)
            }
            Self::Record { fields, columns, present } => {
                let columns = columns.into_iter().map(Self::array).collect::<Result<Vec<_>, _>>()?;
                let nulls = Some(NullBuffer::from(present)).filter(|nulls| nulls.null_count() > 0);
                Arc::new(StructArray::try_new(fields, columns, nulls)?)
            }
        })
    }
}

/// The columns of a table while its rows are added.
#[derive(Debug)]
pub struct Columns {
    schema: SchemaRef,
    columns: Vec<Column>,
}

impl Columns {
    /// Empty columns with these headings.
    pub fn new<'h>(headings: impl IntoIterator<Item = &'h Heading>) -> Self {
        let fields: Vec<Field> = headings.into_iter().map(field).collect();
        Self::of_schema(Arc::new(Schema::new(fields)))
    }

    /// Empty columns of this schema.
    pub fn of_schema(schema: SchemaRef) -> Self {
        let columns = schema.fields().iter().map(|field| Column::of_type(field.data_type())).collect();
        Self { schema, columns }
    }

    /// The fields.
    pub fn schema(&self) -> &SchemaRef {
        &self.schema
    }

    /// Adds a row, one value for each column: first cells of a CSV file, then values.
    pub fn add<'a>(
        &mut self,
        cells: impl IntoIterator<Item = &'a str>,
        values: impl IntoIterator<Item = &'a Value>,
    ) {
        let mut columns = self.columns.iter_mut();
        columns.by_ref().zip(cells).for_each(|(column, cell)| column.add_text(cell));
        columns.zip(values).for_each(|(column, value)| column.add(value));
    }

    /// The rows.
    ///
    /// # Errors
    /// Rows of different lengths, or too many items of lists.
    pub fn batch(self) -> Result<RecordBatch, ArrowError> {
        let arrays = self.columns.into_iter().map(Column::array).collect::<Result<Vec<_>, _>>()?;
        RecordBatch::try_new(self.schema, arrays)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arrow_array::Array;
    use arrow_array::cast::AsArray;
    use arrow_array::types::{Float64Type, Int64Type};
    use cocarry::quantities::{OPTION, TICK, headings};

    #[test]
    fn every_quantity_of_a_tick_has_a_type_a_unit_and_a_meaning() {
        let headings: Vec<Heading> = TICK.into_iter().flatten().map(Heading::from).collect();
        let columns = Columns::new(&headings);
        assert_eq!(columns.schema().fields().len(), headings.len());
        for field in columns.schema().fields() {
            assert!(!field.metadata()["description"].is_empty(), "{field}");
        }
        let x = columns.schema().field_with_name("x_m").unwrap();
        assert_eq!((x.data_type(), x.metadata()["unit"].as_str()), (&DataType::Float64, "m"));
        let DataType::List(option) = columns.schema().field_with_name("options").unwrap().data_type() else {
            panic!("the options are a list")
        };
        let DataType::Struct(fields) = option.data_type() else { panic!("an option is a record") };
        assert_eq!(fields.len(), OPTION.len());
        let (_, length) = fields.find("length_m").unwrap();
        assert_eq!((length.data_type(), length.metadata()["unit"].as_str()), (&DataType::Float64, "m"));
        assert!(!length.metadata()["description"].contains('['));
    }

    #[test]
    fn values_keep_their_bits_and_missing_ones_are_null() {
        let options =
            Heading { name: "options", kind: QuantityKind::List(|| headings(OPTION)), description: "" };
        let headings = [
            Heading { name: "a_m", kind: QuantityKind::Number("m"), description: "a number" },
            Heading { name: "n", kind: QuantityKind::Count, description: "a count" },
            options,
        ];
        let mut columns = Columns::new(&headings);
        let number: f64 = 0.1 + 0.2;
        let left =
            Record::from([("name", "left".into()), ("risk", (-0.0).into()), ("misaligned", true.into())]);
        let list = Value::List(vec![left, Record::from([("name", "right".into())])]);
        columns.add([], [&number.into(), &i64::MAX.into(), &list]);
        columns.add([], [&Value::Missing; 3]);
        columns.add([number.to_string().as_str(), ""], [&Value::Missing]);
        let batch = columns.batch().unwrap();
        let numbers = batch.column(0).as_primitive::<Float64Type>();
        assert_eq!([0, 2].map(|row| numbers.value(row).to_bits()), [number.to_bits(); 2]);
        assert_eq!((numbers.null_count(), batch.column(1).null_count()), (1, 2));
        assert_eq!(batch.column(1).as_primitive::<Int64Type>().value(0), i64::MAX);
        let lists = batch.column(2).as_list::<i32>();
        assert_eq!([0, 1, 2].map(|row| lists.value_length(row)), [2, 0, 0]);
        let records = lists.value(0);
        let records = records.as_struct();
        let risk = records.column_by_name("risk").unwrap().as_primitive::<Float64Type>();
        assert_eq!((risk.value(0).to_bits(), risk.is_null(1)), ((-0.0f64).to_bits(), true));
    }
}
