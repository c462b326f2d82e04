/** Shapes of accounts, roles, gateways and the audit log. Times ending in `_us` are µs UTC; 0 is never. */

export type Right = "view" | "use" | "admin";

/** A right on a site and a device; `*` stands for each of them. */
export interface Permission {
  readonly right: Right;
  readonly site: string;
  readonly device: string;
}

/** Who is signed in. `admin` holds for the whole hub. */
export interface Person {
  readonly name: string;
  readonly role: string;
  readonly admin: boolean;
  readonly factor: boolean;
  readonly idle_ends_us: number;
  readonly ends_us: number;
  readonly permissions: readonly Permission[];
}

/** A device that is open to the person; `stale` counts signals older than their limit. */
export interface DeviceRow {
  readonly site: string;
  readonly site_name: string;
  readonly device: string;
  readonly name: string;
  readonly kind: string;
  readonly online: boolean;
  readonly rights: readonly Right[];
  readonly public: boolean;
  readonly signals: number;
  readonly stale: number;
}

export interface SessionRow {
  readonly id: string;
  readonly created_us: number;
  readonly used_us: number;
  readonly address: string;
  readonly agent: string;
  readonly this: boolean;
}

/** A second factor that waits for its first code. `qr` is the text of an SVG picture. */
export interface FactorOffer {
  readonly secret: string;
  readonly uri: string;
  readonly qr: string;
}

export interface TokenRow {
  readonly id: string;
  readonly name: string;
  readonly permissions: readonly Permission[];
  readonly created_us: number;
  readonly ends_us: number;
  readonly used_us: number;
}

export interface TokenMade {
  readonly id: string;
  readonly token: string;
}

export interface PersonRow {
  readonly id: string;
  readonly name: string;
  readonly role: string;
  readonly disabled: boolean;
  readonly factor: boolean;
  readonly created_us: number;
  readonly used_us: number;
  readonly sessions: number;
}

export interface RoleRow {
  readonly id: string;
  readonly name: string;
  readonly seeded: boolean;
  readonly people: number;
  readonly permissions: readonly Permission[];
}

export interface GatewayRow {
  readonly id: string;
  readonly site: string;
  readonly name: string;
  readonly created_us: number;
  readonly revoked_us: number;
  readonly seen_us: number;
  readonly address: string;
  readonly version: string;
  readonly online: boolean;
}

/** An enrolment code that nobody has used yet. */
export interface CodeRow {
  readonly id: string;
  readonly site: string;
  readonly created_us: number;
  readonly expires_us: number;
}

export interface GatewayList {
  readonly gateways: readonly GatewayRow[];
  readonly codes: readonly CodeRow[];
}

export interface CodeMade {
  readonly id: string;
  readonly code: string;
  readonly expires_us: number;
  readonly command: string;
  readonly fingerprint: string;
  readonly qr: string;
}

export interface AuditRow {
  readonly id: string;
  readonly time_us: number;
  readonly kind: string;
  readonly who: string;
  readonly address: string;
  readonly site: string;
  readonly device: string;
  readonly message: string;
  readonly good: boolean;
}

export interface AuditPage {
  readonly rows: readonly AuditRow[];
  readonly more: boolean;
}

/** `broken` is the first row that does not follow from the one before; 0 for none. */
export interface AuditCheck {
  readonly ok: boolean;
  readonly rows: number;
  readonly broken: number;
}
