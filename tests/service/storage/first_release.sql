BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL,
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0001');
CREATE TABLE answers (
	sequence INTEGER NOT NULL,
	id VARCHAR(64) NOT NULL,
	kind VARCHAR(64) NOT NULL,
	engine INTEGER NOT NULL,
	name VARCHAR(200) NOT NULL,
	created DATETIME NOT NULL,
	state VARCHAR(16) NOT NULL,
	status VARCHAR(16),
	spec BLOB NOT NULL,
	body BLOB,
	etag VARCHAR(64),
	summary JSON NOT NULL,
	problem JSON,
	PRIMARY KEY (sequence),
	UNIQUE (id)
);
CREATE TABLE idempotency_keys (
	"key" VARCHAR(255) NOT NULL,
	body_hash VARCHAR(64) NOT NULL,
	created DATETIME NOT NULL,
	PRIMARY KEY ("key")
);
CREATE TABLE sweep_items (
	sequence INTEGER NOT NULL,
	sweep BIGINT NOT NULL,
	number INTEGER NOT NULL,
	status VARCHAR(16) NOT NULL,
	axis_values JSON NOT NULL,
	quantities JSON NOT NULL,
	gap FLOAT,
	seconds FLOAT NOT NULL,
	design_id VARCHAR(64),
	design BLOB,
	problem JSON,
	PRIMARY KEY (sequence)
);
CREATE TABLE sweep_strikes (
	sweep BIGINT NOT NULL,
	number INTEGER NOT NULL,
	strikes INTEGER NOT NULL,
	PRIMARY KEY (sweep, number)
);
CREATE TABLE sweeps (
	sequence INTEGER NOT NULL,
	id VARCHAR(64) NOT NULL,
	engine INTEGER NOT NULL,
	name VARCHAR(200) NOT NULL,
	created DATETIME NOT NULL,
	started DATETIME,
	finished DATETIME,
	state VARCHAR(16) NOT NULL,
	spec BLOB NOT NULL,
	size INTEGER NOT NULL,
	axes JSON NOT NULL,
	quantities JSON NOT NULL,
	optimal INTEGER NOT NULL,
	feasible INTEGER NOT NULL,
	infeasible INTEGER NOT NULL,
	failed INTEGER NOT NULL,
	owner VARCHAR(64),
	leased_until FLOAT,
	PRIMARY KEY (sequence),
	UNIQUE (id)
);
CREATE INDEX ix_answers_kind ON answers (kind, sequence);
CREATE INDEX ix_answers_state ON answers (state);
CREATE INDEX ix_idempotency_keys_created ON idempotency_keys (created);
CREATE INDEX ix_sweeps_state ON sweeps (state);
CREATE UNIQUE INDEX ix_sweep_items_number ON sweep_items (sweep, number);
CREATE INDEX ix_sweep_items_sequence ON sweep_items (sweep, sequence);
CREATE INDEX ix_sweep_items_status ON sweep_items (sweep, status, sequence);
CREATE INDEX ix_sweep_items_design_id ON sweep_items (design_id);
COMMIT;
