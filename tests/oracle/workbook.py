"""Writes tests/data/workbook: a log of a gantry as openpyxl and odfpy save it, and the same rows as CSV.

    python tests/oracle/workbook.py        # needs openpyxl and odfpy

The sheet begins at row 3, as exports with a title do; one row is blank, one TCP is lost; times are dates. A first sheet is empty.
"""

import csv
import datetime
import pathlib

import openpyxl
from odf.opendocument import OpenDocumentSpreadsheet
from odf.table import Table, TableCell, TableRow
from odf.text import P

OUT = pathlib.Path(__file__).parent.parent / "data" / "workbook"
NAMES = ["t_s", "cmd_X_mm", "cmd_Y_mm", "cmd_Z_mm", "x_mm", "y_mm", "z_mm"]
ROWS = [
    [0.0, 100, 200.5, -30.25, 1.000125, 2, 3],
    [0.5, 101, 200.5, -30.25, None, None, None],
    [1.25, 102.0625, 200.5, -30.25, 3.000125, 2.1, 2.9999999],
]
START = datetime.datetime(2026, 2, 28, 23, 59, 59)


def book(stamps, damaged=None):
    out = openpyxl.Workbook()
    out.active.title = "empty"
    sheet = out.create_sheet("readings")
    for column, name in enumerate(NAMES, 1):
        sheet.cell(3, column, name)
    for line, row in zip([4, 5, 7], ROWS):  # row 6 is blank
        for column, value in enumerate(row, 1):
            if stamps and column == 1:
                value = START + datetime.timedelta(seconds=value)
            sheet.cell(line, column, value)
    if damaged:
        sheet[damaged] = "12.5 mm"
    return out


def main():
    OUT.mkdir(exist_ok=True)
    book(False).save(OUT / "log.xlsx")
    book(True).save(OUT / "stamps.xlsx")
    book(False, "B7").save(OUT / "text.xlsx")
    blank = openpyxl.Workbook()
    blank.save(OUT / "blank.xlsx")
    with open(OUT / "log.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(NAMES)
        writer.writerows(ROWS)
    document = OpenDocumentSpreadsheet()
    table = Table(name="readings")
    for row in [NAMES, *ROWS]:
        line = TableRow()
        for value in row:
            if value is None:
                cell = TableCell()
            elif isinstance(value, str):
                cell = TableCell(valuetype="string")
                cell.addElement(P(text=value))
            else:
                cell = TableCell(valuetype="float", value=str(value))
                cell.addElement(P(text=f"{value:.2f}"))  # as shown, not as stored
            line.addElement(cell)
        table.addElement(line)
    document.spreadsheet.addElement(table)
    document.save(str(OUT / "log.ods"))


main()
