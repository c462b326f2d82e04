/** Shapes of the hub's HTTP interface. */

export type Role = "guest" | "operator" | "admin";
export type Right = "view" | "use" | "admin";

export interface Person {
  readonly name: string;
  readonly role: Role;
}

export interface SiteRow {
  readonly site: string;
  readonly name: string;
  /** IANA name. */
  readonly zone: string;
  readonly online: boolean;
  /** Since when it is online or not. */
  readonly since_us: number;
  /** When the gateway was last heard of; 0 for never. */
  readonly last_seen_us: number;
  readonly devices: number;
  readonly signals: number;
}

export interface SignalInfo {
  readonly id: string;
  readonly address: string;
  readonly name: string;
  readonly type: "number" | "state" | "text" | "position";
  readonly unit: string;
  /** Digits after the point; -1 takes the unit's own. */
  readonly decimals: number;
  readonly minimum: number | null;
  readonly maximum: number | null;
  readonly states: readonly string[];
  readonly frame: "local" | "wgs84";
  /** Older than this it is stale (s). */
  readonly max_age: number;
  readonly primary: boolean;
  readonly channels: readonly string[];
}

export interface StreamInfo {
  readonly id: string;
  readonly address: string;
  readonly name: string;
}

export interface ArgumentInfo {
  readonly id: string;
  readonly name: string;
  readonly type: "number" | "integer" | "boolean" | "text";
  readonly unit: string;
  readonly minimum: number | null;
  readonly maximum: number | null;
  readonly default: number | boolean | string | null;
}

export interface CommandInfo {
  readonly id: string;
  readonly name: string;
  readonly description: string;
  readonly confirm: boolean;
  readonly arguments: readonly ArgumentInfo[];
}

export interface DriveInfo {
  /** m/s */
  readonly max_speed: number;
  /** m/s, positive */
  readonly max_reverse: number;
  /** rad/s */
  readonly max_turn: number;
  /** s */
  readonly ttl: number;
  /** Hz */
  readonly rate: number;
  /** s */
  readonly lease: number;
  /** Address of the stream the driver looks at; empty for none. */
  readonly picture: string;
  /** Address of the position signal; empty for none. */
  readonly position: string;
  readonly stop: boolean;
}

export interface DeviceInfo {
  readonly id: string;
  readonly name: string;
  readonly kind: "vehicle" | "dome" | "telescope" | "camera" | "weather" | "power" | "other";
  readonly signals: readonly SignalInfo[];
  readonly streams: readonly StreamInfo[];
  readonly commands: readonly CommandInfo[];
  readonly drive: DriveInfo | null;
  readonly rights: readonly Right[];
}

export interface SiteDetail {
  readonly site: string;
  readonly name: string;
  readonly zone: string;
  readonly online: boolean;
  readonly catalogue: string;
  readonly devices: readonly DeviceInfo[];
}

export interface HistoryGap {
  readonly from_us: number;
  readonly to_us: number;
  readonly reason: string;
}

export interface HistorySeries {
  readonly address: string;
  readonly t_us: readonly number[];
  /** null where a text stands, or where the robot said no number. */
  readonly v: readonly (number | null)[];
  readonly texts?: readonly (string | null)[];
  readonly kind: "exact" | "minmax";
  readonly gaps: readonly HistoryGap[];
}

export interface History {
  readonly series: readonly HistorySeries[];
}
