-- Records as the first shipped version wrote them. Never edited.
PRAGMA application_id = 1179861825;
BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0001');
CREATE TABLE audit (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	at VARCHAR NOT NULL, 
	"by" VARCHAR NOT NULL, 
	action VARCHAR NOT NULL, 
	patient_id INTEGER, 
	subject VARCHAR NOT NULL, 
	reason VARCHAR NOT NULL, 
	detail JSON NOT NULL
);
INSERT INTO "audit" VALUES(1,'2026-11-23T12:00:03.000000+00:00','op','patient added',1,'patient 1','','{}');
INSERT INTO "audit" VALUES(2,'2026-11-23T12:00:06.000000+00:00','op','visit opened',1,'visit 1','','{}');
INSERT INTO "audit" VALUES(3,'2026-11-23T12:00:08.000000+00:00','op','take filed',1,'take 1','','{"side": "left", "load": "seated", "number": 1}');
INSERT INTO "audit" VALUES(4,'2026-11-23T12:00:10.000000+00:00','op','result filed',1,'take 1','','{"result": 1, "refused": false}');
INSERT INTO "audit" VALUES(5,'2026-11-23T12:00:11.000000+00:00','op','foot declared',1,'visit 1, left foot','','{"changed": ["missing", "dressings", "deformity"]}');
INSERT INTO "audit" VALUES(6,'2026-11-23T12:00:12.000000+00:00','op','take in use',1,'take 1','','{}');
INSERT INTO "audit" VALUES(7,'2026-11-23T12:00:14.000000+00:00','op','landmark placed',1,'take 1','','{"landmark": "pternion", "xyz_world": [1.0, 2.0, 3.0]}');
INSERT INTO "audit" VALUES(8,'2026-11-23T12:00:15.000000+00:00','op','take judged',1,'take 1','slight sway','{"verdict": "with_remark"}');
CREATE TABLE definitions (
	id INTEGER NOT NULL, 
	name VARCHAR NOT NULL, 
	version VARCHAR NOT NULL, 
	definition VARCHAR NOT NULL, 
	CONSTRAINT pk_definitions PRIMARY KEY (id), 
	CONSTRAINT uq_definitions_name UNIQUE (name, version)
);
INSERT INTO "definitions" VALUES(1,'foot_length','v1','heel to toe');
INSERT INTO "definitions" VALUES(2,'ball_girth','v1','tape around the ball');
CREATE TABLE feet (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	visit_id INTEGER NOT NULL, 
	side VARCHAR NOT NULL, 
	missing JSON NOT NULL, 
	dressings VARCHAR NOT NULL, 
	deformity VARCHAR NOT NULL, 
	not_scanned VARCHAR NOT NULL, 
	CONSTRAINT ck_feet_side CHECK (side IN ('left', 'right')), 
	CONSTRAINT fk_feet_visit_id FOREIGN KEY(visit_id) REFERENCES visits (id) ON DELETE CASCADE, 
	CONSTRAINT uq_feet_visit_id UNIQUE (visit_id, side)
);
INSERT INTO "feet" VALUES(1,1,'left','["toe_5"]','plaster','bunion','');
CREATE TABLE landmarks (
	id INTEGER NOT NULL, 
	take_id INTEGER NOT NULL, 
	name VARCHAR NOT NULL, 
	x_world_mm FLOAT NOT NULL, 
	y_world_mm FLOAT NOT NULL, 
	z_world_mm FLOAT NOT NULL, 
	placed_by VARCHAR NOT NULL, 
	placed VARCHAR NOT NULL, 
	CONSTRAINT pk_landmarks PRIMARY KEY (id), 
	CONSTRAINT fk_landmarks_take_id FOREIGN KEY(take_id) REFERENCES takes (id) ON DELETE CASCADE, 
	CONSTRAINT uq_landmarks_take_id UNIQUE (take_id, name)
);
INSERT INTO "landmarks" VALUES(1,1,'pternion',1.0,2.0,3.0,'op','2026-11-23T12:00:13.000000+00:00');
CREATE TABLE measurements (
	id INTEGER NOT NULL, 
	result_id INTEGER NOT NULL, 
	definition_id INTEGER NOT NULL, 
	value FLOAT, 
	unit VARCHAR NOT NULL, 
	reliable BOOLEAN NOT NULL, 
	reason VARCHAR NOT NULL, 
	low FLOAT, 
	high FLOAT, 
	unusual VARCHAR, 
	CONSTRAINT pk_measurements PRIMARY KEY (id), 
	CONSTRAINT fk_measurements_definition_id FOREIGN KEY(definition_id) REFERENCES definitions (id), 
	CONSTRAINT fk_measurements_result_id FOREIGN KEY(result_id) REFERENCES results (id) ON DELETE CASCADE, 
	CONSTRAINT uq_measurements_result_id UNIQUE (result_id, definition_id)
);
INSERT INTO "measurements" VALUES(1,1,1,251.25,'mm',1,'',NULL,NULL,NULL);
INSERT INTO "measurements" VALUES(2,1,2,240.5,'mm',0,'not seen',231.0,250.0,'wide');
CREATE TABLE patients (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	name VARCHAR NOT NULL, 
	name_key VARCHAR NOT NULL, 
	search_key VARCHAR NOT NULL, 
	born DATE, 
	number VARCHAR, 
	notes VARCHAR NOT NULL, 
	created VARCHAR NOT NULL, 
	CONSTRAINT uq_patients_number UNIQUE (number)
);
INSERT INTO "patients" VALUES(1,'Ana Łódź','ana łódź','ana lodz','1962-03-31','A-7','two
lines','2026-11-23T12:00:02.000000+00:00');
CREATE TABLE results (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	take_id INTEGER NOT NULL, 
	computed VARCHAR NOT NULL, 
	side VARCHAR NOT NULL, 
	load VARCHAR NOT NULL, 
	missing JSON NOT NULL, 
	calibration_sha256 VARCHAR NOT NULL, 
	settings JSON NOT NULL, 
	versions JSON NOT NULL, 
	refused VARCHAR NOT NULL, 
	files_sha256 VARCHAR NOT NULL, 
	calibration_files VARCHAR, 
	CONSTRAINT ck_results_load CHECK (load IN ('unknown', 'unloaded', 'seated', 'bipedal', 'single_leg')), 
	CONSTRAINT ck_results_side CHECK (side IN ('left', 'right')), 
	CONSTRAINT fk_results_calibration_files FOREIGN KEY(calibration_files) REFERENCES stored (sha256), 
	CONSTRAINT fk_results_files_sha256 FOREIGN KEY(files_sha256) REFERENCES stored (sha256), 
	CONSTRAINT fk_results_take_id FOREIGN KEY(take_id) REFERENCES takes (id) ON DELETE CASCADE
);
INSERT INTO "results" VALUES(1,1,'2026-11-23T12:00:09.000000+00:00','left','seated','["toe_5"]','cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc','{"threshold": null}','{"footscan": "0.1"}','','1884c4f60bece9e0fadd0f858d44bdaa016643125269c758de41197e8a2f3018','d0f788c4eba0c96f6e3b1b066adbc3529516c0e284c314c0a044e92cee8ca201');
CREATE TABLE stored (
	sha256 VARCHAR NOT NULL, 
	kind VARCHAR NOT NULL, 
	size_bytes INTEGER NOT NULL, 
	stored VARCHAR NOT NULL, 
	discarded BOOLEAN NOT NULL, 
	CONSTRAINT pk_stored PRIMARY KEY (sha256)
);
INSERT INTO "stored" VALUES('d14996d9e2bc366ae4b390ebe977b521e4425951a88592708acd8d20e5129d64','recording',2,'2026-11-23T12:00:04.000000+00:00',0);
INSERT INTO "stored" VALUES('d0f788c4eba0c96f6e3b1b066adbc3529516c0e284c314c0a044e92cee8ca201','calibration',1,'2026-11-23T12:00:04.000000+00:00',0);
INSERT INTO "stored" VALUES('1884c4f60bece9e0fadd0f858d44bdaa016643125269c758de41197e8a2f3018','results',2,'2026-11-23T12:00:04.000000+00:00',0);
CREATE TABLE takes (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	foot_id INTEGER NOT NULL, 
	number INTEGER NOT NULL, 
	load VARCHAR NOT NULL, 
	load_kg FLOAT, 
	surface VARCHAR NOT NULL, 
	surface_mm FLOAT, 
	wedge_mm FLOAT, 
	operator VARCHAR NOT NULL, 
	machine VARCHAR, 
	recorded VARCHAR NOT NULL, 
	filed VARCHAR NOT NULL, 
	finished BOOLEAN NOT NULL, 
	verdict VARCHAR NOT NULL, 
	verdict_by VARCHAR NOT NULL, 
	verdict_remark VARCHAR NOT NULL, 
	in_use BOOLEAN NOT NULL, 
	source VARCHAR, 
	recording_sha256 VARCHAR NOT NULL, 
	calibration_files VARCHAR, 
	CONSTRAINT ck_takes_load CHECK (load IN ('unknown', 'unloaded', 'seated', 'bipedal', 'single_leg')), 
	CONSTRAINT ck_takes_surface CHECK (surface IN ('unknown', 'bare', 'sock', 'bandage', 'dressing')), 
	CONSTRAINT ck_takes_verdict CHECK (verdict IN ('undecided', 'accepted', 'with_remark', 'repeat')), 
	CONSTRAINT fk_takes_calibration_files FOREIGN KEY(calibration_files) REFERENCES stored (sha256), 
	CONSTRAINT fk_takes_foot_id FOREIGN KEY(foot_id) REFERENCES feet (id) ON DELETE CASCADE, 
	CONSTRAINT fk_takes_recording_sha256 FOREIGN KEY(recording_sha256) REFERENCES stored (sha256), 
	CONSTRAINT uq_takes_foot_id UNIQUE (foot_id, number), 
	CONSTRAINT uq_takes_recording_sha256 UNIQUE (recording_sha256)
);
INSERT INTO "takes" VALUES(1,1,1,'seated',NULL,'bare',NULL,NULL,'op','m-1','2026-11-23T12:00:00.000000+00:00','2026-11-23T12:00:07.000000+00:00',1,'with_remark','op','slight sway',1,'20261123-120000-left','d14996d9e2bc366ae4b390ebe977b521e4425951a88592708acd8d20e5129d64','d0f788c4eba0c96f6e3b1b066adbc3529516c0e284c314c0a044e92cee8ca201');
CREATE TABLE visits (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	patient_id INTEGER NOT NULL, 
	day DATE NOT NULL, 
	opened VARCHAR NOT NULL, 
	operator VARCHAR NOT NULL, 
	notes VARCHAR NOT NULL, 
	CONSTRAINT fk_visits_patient_id FOREIGN KEY(patient_id) REFERENCES patients (id) ON DELETE CASCADE
);
INSERT INTO "visits" VALUES(1,1,'2026-11-23','2026-11-23T12:00:05.000000+00:00','op','');
CREATE INDEX ix_patients_name_key ON patients (name_key, born);
CREATE INDEX ix_visits_patient_id ON visits (patient_id);
CREATE INDEX ix_takes_calibration_files ON takes (calibration_files);
CREATE INDEX ix_takes_foot_id ON takes (foot_id);
CREATE UNIQUE INDEX ix_takes_in_use ON takes (foot_id, load) WHERE in_use;
CREATE INDEX ix_results_calibration_files ON results (calibration_files);
CREATE INDEX ix_results_files_sha256 ON results (files_sha256);
CREATE INDEX ix_results_take_id ON results (take_id);
CREATE INDEX ix_measurements_definition_id ON measurements (definition_id);
CREATE INDEX ix_audit_patient_id ON audit (patient_id);
CREATE TRIGGER audit_no_update BEFORE UPDATE ON audit BEGIN SELECT RAISE(ABORT, 'the log of the records can only be added to'); END;
CREATE TRIGGER audit_no_delete BEFORE DELETE ON audit BEGIN SELECT RAISE(ABORT, 'the log of the records can only be added to'); END;
CREATE TRIGGER audit_no_replace BEFORE INSERT ON audit WHEN EXISTS (SELECT 1 FROM audit WHERE id = NEW.id) BEGIN SELECT RAISE(ABORT, 'the log of the records can only be added to'); END;
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('patients',1);
INSERT INTO "sqlite_sequence" VALUES('audit',8);
INSERT INTO "sqlite_sequence" VALUES('visits',1);
INSERT INTO "sqlite_sequence" VALUES('feet',1);
INSERT INTO "sqlite_sequence" VALUES('takes',1);
INSERT INTO "sqlite_sequence" VALUES('results',1);
COMMIT;
