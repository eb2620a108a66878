//! Pictures, made on the processor.
