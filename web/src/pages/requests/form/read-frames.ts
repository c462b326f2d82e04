/** Reads the frames of a request, by what its site can do. Pure. */

import { msg, str } from "@lit/localize";
import type { AbilitiesShape, ConfigurationShape, SettingRangeShape } from "../../../generated/api.js";
import { IMAGE_WORDS, rowField, type FramesDraft, type RequestDraft, type RequestField } from "./draft.js";
import type { FieldReader, NumberRange } from "./field-reader.js";

export function readFrames(draft: RequestDraft, fields: FieldReader<RequestField>, abilities: AbilitiesShape | null): readonly ConfigurationShape[] {
  const read = draft.frames.map((row, i) => readRow(row, i, fields, abilities));
  if (read.length === 0) fields.problems.set("frames", msg("Add at least one row of frames."));
  const kinds = new Set(draft.frames.map(({ type }) => (type === "BIAS" ? "DARK" : type)));
  // Each kind is taken at a time of its own.
  if (kinds.size > 1) fields.problems.set("frames", msg("One request has light frames, twilight flats, or darks and bias, not several of them: make a request for each."));
  if (draft.way === "none" && kinds.has("LIGHT")) fields.problems.set("way", msg("Light frames need a target; without one only darks, bias and flats are taken."));
  return read;
}

function readRow(row: FramesDraft, i: number, fields: FieldReader<RequestField>, abilities: AbilitiesShape | null): ConfigurationShape {
  checkRow(row, i, fields, abilities);
  const light = row.type === "LIGHT" ? (abilities?.exposure ?? null) : null;
  return {
    type: row.type,
    filter: row.filter.trim(),
    exposure: fields.number(rowField("exposure", i), row.exposure, within(light, [0, 86_400]), msg("Exposure in s")),
    count: fields.whole(rowField("count", i), row.count, [1, 10_000], msg("Frames")),
    binning: fields.whole(rowField("binning", i), row.binning, within(abilities?.binning ?? null, [1, 16]), msg("Binning")),
    gain: fields.optional(rowField("gain", i), row.gain, within(abilities?.gain ?? null, [-1e6, 1e6]), msg("Gain"), null),
    dither: fields.number(rowField("dither", i), row.dither, [0, 600], msg("Dither in ″")),
    guiding: row.guiding,
  };
}

/** What a site cannot do is said before it is asked. */
function checkRow({ type, filter, binning, gain, guiding }: FramesDraft, i: number, { problems }: FieldReader<RequestField>, abilities: AbilitiesShape | null): void {
  if (abilities === null) return;
  const { filters, types } = abilities;
  if (!types.includes(type)) problems.set(rowField("type", i), msg(str`This site takes none of these for requests: ${IMAGE_WORDS[type]}.`));
  if (filters !== null && filter.trim() !== "" && !filters.includes(filter.trim())) problems.set(rowField("filter", i), msg(str`There is no such filter; there are ${filters.join(", ")}.`));
  if (abilities.binning === null && binning.trim() !== "1") problems.set(rowField("binning", i), msg("This site cannot choose a binning: leave it at 1."));
  if (abilities.gain === null && gain.trim() !== "") problems.set(rowField("gain", i), msg("This site cannot choose a gain: leave it empty."));
  if (!abilities.guides && guiding === "ON") problems.set(rowField("guiding", i), msg("This site has no guider: choose off or optional."));
}

function within(range: SettingRangeShape | null, [low, high]: NumberRange): NumberRange {
  return [Math.max(low, range?.low ?? low), Math.min(high, range?.high ?? high)];
}
