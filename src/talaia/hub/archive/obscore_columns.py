"""The columns of IVOA ObsCore 1.1. Pure data.

Names, units, UCDs and Utypes are those of the recommendation's table 1 (Observation Data Model
Core Components and its Implementation in the Table Access Protocol, version 1.1, 2017): the 30
that every service has to have, in its order. `proposal_id` (its table 7) and the pictures' quality
come behind them.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["COLUMNS", "ObscoreColumn"]


class ObscoreColumn(NamedTuple):
    """One column of the table: name, VOTable type, unit, UCD and Utype."""

    name: str
    kind: str
    unit: str = ""
    ucd: str = ""
    utype: str = ""


# Name, VOTable type, unit, UCD, Utype; a dash where there is none. Utypes begin with `obscore:`.
_TABLE = """
dataproduct_type char - meta.id ObsDataset.dataProductType
calib_level int - meta.code;obs.calib ObsDataset.calibLevel
obs_collection char - meta.id DataID.collection
obs_id char - meta.id DataID.observationID
obs_publisher_did char - meta.ref.ivoid Curation.publisherDID
access_url char - meta.ref.url Access.reference
access_format char - meta.code.mime Access.format
access_estsize long kbyte phys.size;meta.file Access.size
target_name char - meta.id;src Target.name
s_ra double deg pos.eq.ra Char.SpatialAxis.Coverage.Location.Coord.Position2D.Value2.C1
s_dec double deg pos.eq.dec Char.SpatialAxis.Coverage.Location.Coord.Position2D.Value2.C2
s_fov double deg phys.angSize;instr.fov Char.SpatialAxis.Coverage.Bounds.Extent.diameter
s_region char - pos.outline;obs.field Char.SpatialAxis.Coverage.Support.Area
s_xel1 long - meta.number Char.SpatialAxis.numBins1
s_xel2 long - meta.number Char.SpatialAxis.numBins2
s_resolution double arcsec pos.angResolution Char.SpatialAxis.Resolution.Refval.value
t_min double d time.start;obs.exposure Char.TimeAxis.Coverage.Bounds.Limits.StartTime
t_max double d time.end;obs.exposure Char.TimeAxis.Coverage.Bounds.Limits.StopTime
t_exptime double s time.duration;obs.exposure Char.TimeAxis.Coverage.Support.Extent
t_resolution double s time.resolution Char.TimeAxis.Resolution.Refval.value
t_xel long - meta.number Char.TimeAxis.numBins
em_min double m em.wl;stat.min Char.SpectralAxis.Coverage.Bounds.Limits.LoLimit
em_max double m em.wl;stat.max Char.SpectralAxis.Coverage.Bounds.Limits.HiLimit
em_res_power double - spect.resolution Char.SpectralAxis.Resolution.ResolPower.refVal
em_xel long - meta.number Char.SpectralAxis.numBins
o_ucd char - meta.ucd Char.ObservableAxis.ucd
pol_states char - meta.code;phys.polarization Char.PolarizationAxis.stateList
pol_xel long - meta.number Char.PolarizationAxis.numBins
facility_name char - meta.id;instr.tel Provenance.ObsConfig.Facility.name
instrument_name char - meta.id;instr Provenance.ObsConfig.Instrument.name
proposal_id char - meta.id;obs.proposal Provenance.Proposal.identifier
filter_name char - meta.id;instr.filter -
star_count long - meta.number;src -
sky_background double adu phot.count;instr.background -
zero_point double mag phot.mag;arith.zp -
"""

COLUMNS = tuple(
    ObscoreColumn(*("" if word == "-" else word for word in line.split()))
    for line in _TABLE.strip().splitlines()
)
