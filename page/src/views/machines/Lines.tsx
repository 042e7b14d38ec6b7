import type { ComponentChildren } from "preact";
import type { LocationError, Machine, RotaryAxis, Vector } from "../../api/types";
import { Num } from "../../parts/Num";
import { Card } from "../../parts/parts";
import { type Column, Table } from "../../parts/Table";
import { to } from "../../router";
import { texts } from "../../texts";

const ERRORS = ["e_x_um", "e_y_um", "e_z_um", "e_a_urad", "e_b_urad", "e_c_urad"] as const satisfies (keyof LocationError)[];

const numbers = (vector: Vector) => vector.map((part) => Number(part.toFixed(4))).join("  ");

interface Props {
  machine: Machine;
  calibration: string | null;
  children?: ComponentChildren;
}

/** The lines of the rotary axes, their limits and their location errors. */
export function Lines({ machine, calibration, children }: Props) {
  const t = texts.value.machines;
  return (
    <Card title={t.errors}>
      <Table
        label={t.errors}
        class="list numeric"
        rows={machine.kinematics.rotary_axes}
        keyOf={(axis) => axis.name}
        data="axis"
        columns={[
          { head: t.axis, cell: (axis) => axis.name, names: true },
          { head: t.side, cell: (axis) => t.sides[axis.side] },
          { head: t.direction, cell: (axis) => numbers(axis.direction), class: "num nowrap" },
          { head: t.point, cell: (axis) => numbers(axis.point_mm), class: "num nowrap" },
          {
            head: t.limits,
            cell: (axis) => (axis.limits_deg ? `${axis.limits_deg.join("…")}°`.replaceAll("-", "−") : t.unlimited),
            class: "num nowrap",
          },
          ...ERRORS.map((name): Column<RotaryAxis> => ({
            head: name.replace(/_u(m|rad)$/, "").replaceAll("_", ""),
            unit: name.endsWith("um") ? "µm" : "µrad",
            cell: (axis) => <Num value={axis.location_error?.[name] ?? 0} />,
            class: "right",
          })),
        ]}
      />
      {calibration && (
        <p class="hint">
          {t.fromRun} <a href={to("calibrate", machine.machine_id, calibration)}>{t.openRun}</a>
        </p>
      )}
      {children}
    </Card>
  );
}
