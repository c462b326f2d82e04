/**
 * Whether the weather lets the roof open: the word of the interlocks that decide, and by which
 * numbers. It is never kinder than what is known: what is missing or old makes it *unknown*. Pure.
 */

import { msg, str } from "@lit/localize";
import type { InterlockUpdate } from "../../generated/wire.js";
import { differenceToShown, formatWithUnit, shownDifferenceText, shownText, shownUnit, toShown } from "../../format/unit.js";
import type { LimitShape, RuleShape, SignalShape } from "../../generated/api.js";
import { eitherText } from "../../words/lists.js";

export type VerdictWord = "safe" | "warn" | "wait" | "unsafe" | "overridden" | "unknown" | "none";

export const VERDICT_WORDS: Readonly<Record<VerdictWord, string>> = {
  safe: msg("Safe"),
  warn: msg("Warning", { id: "warning.weather" }),
  wait: msg("Wait"),
  unsafe: msg("Unsafe"),
  overridden: msg("Overridden"),
  unknown: msg("Unknown"),
  none: msg("No rule"),
};
/** The shape and colour that a status shows it with. */
export const VERDICT_KINDS: Readonly<Record<VerdictWord, "ok" | "warn" | "bad" | "unknown">> = {
  safe: "ok",
  warn: "warn",
  wait: "warn",
  unsafe: "bad",
  overridden: "warn",
  unknown: "unknown",
  none: "unknown",
};

/** What is known of a signal now. */
export interface KnownValue {
  readonly fresh: boolean;
  readonly value: number;
  /** Of a state: its word. */
  readonly word: string;
}

export interface LimitLine {
  readonly rule: string;
  readonly name: string;
  readonly signal: string;
  readonly stands: "fine" | "beyond" | "returning" | "unknown";
  readonly now: string;
  readonly limit: string;
  /** How far it is on the way to its limit, 0 to 1; NaN for states and for limits below. */
  readonly part: number;
}

export interface WeatherVerdict {
  readonly word: VerdictWord;
  /** The first cause, as a sentence. */
  readonly why: string;
  readonly since_us: number;
  readonly rule: string;
}

/** The rules of which a condition is about this device. */
export function rulesAbout(rules: readonly RuleShape[], device: string): readonly RuleShape[] {
  return rules.filter(({ conditions }) =>
    conditions.some(({ limits }) => limits.some(({ signal }) => signal.startsWith(`${device}/`))),
  );
}

/** A weather station of a site, and what is known of it now. */
export interface WeatherStation {
  /** All rules of its site. */
  readonly rules: readonly RuleShape[];
  readonly device: { readonly id: string; readonly signals: readonly SignalShape[] };
  readonly online: boolean;
  readonly news: (rule: RuleShape) => InterlockUpdate | undefined;
  readonly known: (signal: SignalShape) => KnownValue;
}

/** The rules about a station, how each of their limits stands, and what follows for the roof. */
export function judgeStation({ rules: all, device, online, news, known }: WeatherStation): {
  readonly rules: readonly RuleShape[];
  readonly lines: readonly LimitLine[];
  readonly verdict: WeatherVerdict;
} {
  const rules = rulesAbout(all, device.id);
  const lines = limitLines(rules, device.id, device.signals, known, news);
  return { rules, lines, verdict: verdictOf(online, rules, news, lines) };
}

/** Each limit that these rules set for a device's signals, with how it stands. */
export function limitLines(
  rules: readonly RuleShape[], device: string, signals: readonly SignalShape[], known: (signal: SignalShape) => KnownValue,
  news: (rule: RuleShape) => InterlockUpdate | undefined = () => undefined,
): readonly LimitLine[] {
  const lines = rules.flatMap((rule) =>
    rule.conditions.flatMap(({ limits, lasting }) => {
      // A value may arrive and be worth nothing: frozen, out of range, old. The gateway knows.
      const doubted = news(rule)?.unknown.includes(conditionId(limits)) === true;
      return limits
        .filter(({ signal }) => signal.startsWith(`${device}/`))
        .flatMap((limit) => {
          const signal = signals.find(({ address }) => address === limit.signal);
          if (signal === undefined) return [];
          const other = signals.find(({ address }) => address === (limit.minus || limit.humidity));
          const now = limit.minus + limit.humidity === "" ? known(signal) : valueDifference(known(signal), other && known(other), limit.humidity !== "");
          const less = limit.humidity !== "" ? msg("dew point") : other?.name;
          return [
            {
              rule: rule.name,
              name: less === undefined ? signal.name : msg(str`${signal.name} minus ${less}`),
              signal: signal.address,
              stands: doubted ? "unknown" : standsOf(limit, now),
              now: now.fresh ? (signal.type === "state" ? now.word : (less === undefined ? shownText : shownDifferenceText)(signal, now.value)) : msg("unknown"),
              limit: limitText(limit, signal, lasting, less !== undefined),
              part: now.fresh && limit.above !== null && limit.above > 0 ? now.value / limit.above : Number.NaN,
            },
          ];
        });
    }),
  );
  const rank = { beyond: 0, unknown: 1, returning: 2, fine: 3 } as const;
  return [...lines].sort((a, b) => rank[a.stands] - rank[b.stands]);
}

/** Names a condition as the gateway does in its news. */
function conditionId(limits: readonly LimitShape[]): string {
  return limits.map(({ signal, minus, humidity }) => [signal, minus, humidity].filter((part) => part !== "").join("+")).join("+").slice(0, 200);
}

/** How far two values are apart, or a temperature (°C) from the dew point at a humidity (%). */
function valueDifference(first: KnownValue, other: KnownValue | undefined, humid: boolean): KnownValue {
  const value = first.value - (humid ? dewPoint(first.value, other?.value ?? Number.NaN) : (other?.value ?? Number.NaN));
  return { fresh: first.fresh && other?.fresh === true && !Number.isNaN(value), value, word: "" };
}

/** As the gateway computes it: the Magnus form with the coefficients of Alduchov and Eskridge (1996). */
function dewPoint(temperature: number, humidity: number): number {
  if (!(humidity > 0)) return Number.NaN;
  const gamma = Math.log(Math.min(humidity, 100) / 100) + (17.625 * temperature) / (243.04 + temperature);
  return (243.04 * gamma) / (17.625 - gamma);
}

function standsOf(limit: LimitShape, { fresh, value, word }: KnownValue): LimitLine["stands"] {
  if (!fresh) return "unknown";
  if (limit.states.length > 0 && limit.states.includes(word)) return "beyond";
  if (limit.safe_states.length > 0 && !limit.safe_states.includes(word)) return "beyond";
  if ((limit.above !== null && value > limit.above) || (limit.below !== null && value < limit.below)) return "beyond";
  // Between the limit that closes and the one that lets go again: what it means, the gateway knows.
  const high = limit.until_below !== null && value >= limit.until_below;
  const low = limit.until_above !== null && value <= limit.until_above;
  return high || low ? "returning" : "fine";
}

/** @param apart the limit is of a difference of two values */
function limitText(limit: LimitShape, signal: SignalShape, lasting: number, apart: boolean): string {
  const { unit, decimals } = shownUnit(signal);
  const numberText = (value: number): string => {
    const shown = (apart ? differenceToShown : toShown)(signal.shown, value);
    return formatWithUnit(shown, unit, Number.isInteger(shown) ? 0 : decimals);
  };
  const parts = [
    limit.above === null ? "" : limit.until_below === null ? msg(str`above ${numberText(limit.above)}`) : msg(str`above ${numberText(limit.above)} until below ${numberText(limit.until_below)}`),
    limit.below === null ? "" : limit.until_above === null ? msg(str`below ${numberText(limit.below)}`) : msg(str`below ${numberText(limit.below)} until above ${numberText(limit.until_above)}`),
    limit.states.length === 0 ? "" : msg(str`when ${eitherText(limit.states)}`),
    limit.safe_states.length === 0 ? "" : msg(str`unless ${eitherText(limit.safe_states)}`),
  ].filter((part) => part !== "");
  const beyond = parts.length === 0 ? msg("when unknown") : parts.join(", ");
  return lasting > 0 ? msg(str`${beyond} for ${String(lasting)} s`) : beyond;
}

/** What decides, of these rules' news, and the lines by which. */
export function verdictOf(
  online: boolean, rules: readonly RuleShape[], news: (rule: RuleShape) => InterlockUpdate | undefined, lines: readonly LimitLine[],
): WeatherVerdict {
  const none = { why: "", since_us: 0, rule: "" };
  if (!online) return { ...none, word: "unknown", why: msg("No data from the site: the weather is unknown.") };
  if (rules.length === 0) return { ...none, word: "none" };
  const missing = lines.find(({ stands }) => stands === "unknown");
  const told = rules.map((rule) => ({ rule, said: news(rule) }));
  const bad = told.find(({ said }) => said?.unsafe === true && said.overridden_by === "");
  if (bad?.said !== undefined) {
    const word = missing === undefined ? "unsafe" : "unknown";
    return { word, why: bad.said.why === "" ? causeOf(lines) : `${bad.said.why}.${currentNumber(bad.said.why, lines)}`, since_us: bad.said.since_us, rule: bad.rule.name };
  }
  const over = told.find(({ said }) => (said?.overridden_by ?? "") !== "");
  if (over?.said !== undefined) {
    const why = msg(str`${over.said.overridden_by} has overridden ${over.rule.name}.`);
    return { word: "overridden", why, since_us: 0, rule: over.rule.name };
  }
  if (missing !== undefined) {
    return { ...none, word: "unknown", why: msg(str`${missing.name} is unknown, and that counts as unsafe.`), rule: missing.rule };
  }
  const silent = told.find(({ said }) => said === undefined);
  if (silent !== undefined) {
    return { ...none, word: "unknown", why: msg(str`The gateway has not said yet how ${silent.rule.name} stands.`), rule: silent.rule.name };
  }
  const waits = told.find(({ said }) => said?.locked === true);
  if (waits?.said !== undefined) {
    return { word: "wait", why: msg("Safe now, but not for long enough yet."), since_us: waits.said.since_us, rule: waits.rule.name };
  }
  const beyond = lines.find(({ stands }) => stands === "beyond");
  if (beyond !== undefined) {
    return { ...none, word: "warn", why: msg(str`${beyond.name} is ${beyond.now}, beyond its limit (${beyond.limit}).`), rule: beyond.rule };
  }
  const nearest = lines.filter(({ part }) => part > 0).sort((a, b) => b.part - a.part)[0];
  const near = nearest === undefined ? "" : msg(str` Nearest to its limit: ${nearest.name}, ${nearest.now} (unsafe ${nearest.limit}).`);
  return { ...none, word: "safe", why: msg(str`Every value is within its limits.${near}`) };
}

/** The number behind a reason that names a limit only. */
function currentNumber(why: string, lines: readonly LimitLine[]): string {
  const line = lines.find(({ name, part }) => why.startsWith(name) && !Number.isNaN(part));
  return line === undefined || why.includes(line.now) ? "" : msg(str` Now ${line.now}.`);
}

function causeOf(lines: readonly LimitLine[]): string {
  const worst = lines[0];
  return worst === undefined || worst.stands === "fine" ? "" : msg(str`${worst.name}: ${worst.now} (closes ${worst.limit}).`);
}
